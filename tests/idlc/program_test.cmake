# canorb-idlc as people call it: IDLC the program, SOURCE this folder, WORK a folder to write to.
file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK})
set(directory ${SOURCE}/golden)

# run(EXPECTED_CODE PATTERN arguments...): the exit code, and what the output must match.
function(run expected_code pattern)
    execute_process(COMMAND ${IDLC} ${ARGN} WORKING_DIRECTORY ${directory}
        RESULT_VARIABLE code OUTPUT_VARIABLE output ERROR_VARIABLE output)
    if(NOT code EQUAL expected_code)
        message(SEND_ERROR "${ARGN}: exit code ${code}, not ${expected_code}\n${output}")
    endif()
    if(NOT output MATCHES "${pattern}")
        message(SEND_ERROR "${ARGN}: this does not match '${pattern}'\n${output}")
    endif()
endfunction()

# same(FILE TEXT WHAT)
function(same file text what)
    file(READ ${file} content)
    if(NOT content STREQUAL text)
        message(SEND_ERROR "${what}:\n${content}")
    endif()
endfunction()

run(0 "--output-dir.*Examples:" --help)
run(0 "^canorb-idlc [0-9]+\\.[0-9]+\\.[0-9]+\n$" --version)

# A wrong command line.
run(2 "FILE" )
run(2 "--nonsense" --nonsense devices.idl)
run(2 "At most|at most" --check --print-ids devices.idl)
run(2 "nonsense not in {.*deps" --emit nonsense devices.idl)
run(2 "--depfile: " --check --depfile ${WORK}/never.d devices.idl)
run(2 "standard input" -)

# Files that cannot be compiled, or written.
run(1 "^no_such_file.idl: error: no such file" no_such_file.idl)
run(1 "^[.]: error: is a directory" --check .)
run(1 "^/dev/null: error: is not a regular file" --check /dev/null)
run(1 "names_unknown.idl:3:3: error: there is no type 'Missing'" ../errors/names_unknown.idl)
run(2 "errors/../golden/types.idl: error: would be written to ${WORK}/types.hpp, as types.idl is"
    -o ${WORK} types.idl ../errors/../golden/types.idl)
file(COPY_FILE ${SOURCE}/golden/types.idl ${WORK}/types.hpp)
run(2 "would be overwritten" -o ${WORK} ${WORK}/types.hpp)
file(COPY_FILE ${SOURCE}/golden/types.idl ${WORK}/.idl)
run(2 "rename it" -o ${WORK} ${WORK}/.idl)
run(1 "types.hpp/x: error: cannot be made: Not a directory" -o ${WORK}/types.hpp/x types.idl)
file(MAKE_DIRECTORY ${WORK}/taken/types.cpp)
run(1 "taken/types.cpp: error: cannot be written: Is a directory" -o ${WORK}/taken types.idl)
if(EXISTS /dev/full)
    run(1 "^/dev/full: error: cannot be written: No space left"
        -o ${WORK}/made --depfile /dev/full types.idl)
    execute_process(COMMAND sh -c "'${IDLC}' --print-ids devices.idl >/dev/full"
        WORKING_DIRECTORY ${directory} RESULT_VARIABLE code ERROR_VARIABLE output)
    if(NOT code EQUAL 1 OR NOT output MATCHES "standard output: error: cannot be written")
        message(SEND_ERROR "a full disk goes unnoticed: ${code} ${output}")
    endif()
endif()

# What else it can do.
run(0 "^$" --check devices.idl types.idl)
run(0 "    5  _set_ramp\n" --print-ids devices.idl)
run(0 "\n[0-9A-F]+ Devices::Motor\n$" --print-hash devices.idl)
run(0 "^{.*\"Devices::Motor\"|\"Motor\"" --emit json devices.idl)
run(0 "nothing differs" --compat devices.idl devices.idl)
run(1 "breaks: [1-9]" --compat devices.idl types.idl)
run(1 "there is no type 'Missing'" --compat devices.idl ../errors/names_unknown.idl)
run(2 "--compat: needs two files" --compat devices.idl)
run(0 "^module .*  interface Motor" --dump-ast devices.idl)
run(0 "^gen/includes.hpp gen/includes.cpp: .*\n  includes.idl .*\n  types.idl\n$"
    --emit deps -o gen includes.idl)
run(0 "^$" --output-dir ${WORK}/made --depfile ${WORK}/includes.d includes.idl)
file(READ ${SOURCE}/golden/includes.hpp golden)
same(${WORK}/made/includes.hpp "${golden}" "the program writes something else than the library")
file(READ ${WORK}/includes.d dependencies)
foreach(name made/includes.hpp made/includes.cpp " includes.idl" " devices.idl" " types.idl")
    string(FIND "${dependencies}" "${name}" at)
    if(at EQUAL -1)
        message(SEND_ERROR "the depfile does not name '${name}':\n${dependencies}")
    endif()
endforeach()

# What is good IDL and has no code: a warning of --check, else an error.
run(0 ": warning: no code can be generated: " --check ../errors/operation_ids_clash.idl)
run(1 ": error: the bases of " --print-ids ../errors/operation_ids_clash.idl)

# What it cannot include, in words of its own: where it looked, and who asked for it.
set(directory "${WORK}/with spaces $ and #")
file(MAKE_DIRECTORY "${directory}/inc")
file(WRITE "${directory}/main.idl" "#include \"part.idl\"\n")
file(WRITE "${directory}/part.idl" "// comment\n\t#include <x/nowhere.idl>\n")
run(1 "^part.idl:2:11: error: cannot find the included file <x/nowhere.idl>
\t#include <x/nowhere.idl>
\t         \\^
tried, in this order:
  inc/x/nowhere.idl  \\(-I inc\\)
  absent/x/nowhere.idl  \\(-I absent, which does not exist\\)
[^\n]*
main.idl:1:1: note: included from here
#include \"part.idl\"
\\^
$" -Iinc -I absent --check main.idl)
file(WRITE "${directory}/part.idl" "#include \"nowhere.idl\"\n")
run(1 "tried, in this order:\n  nowhere.idl  .the directory of the including file.\n  inc/nowhere.idl  .-I inc.\n"
    -I inc --check main.idl)
file(WRITE "${directory}/part.idl" "#include <nowhere.idl>\n")
run(1 "tried: nothing." --check main.idl)

# The other words of the preprocessor, and several in one run.
file(WRITE "${directory}/wrong.idl"
    "#ifdef NOTHING\n#else\n#error \"no good\"\n#warning old\n#else\n #nonsense\n#if 1\n")
run(1 "^wrong.idl:3:2: error: #error \"no good\"
#error \"no good\"
 \\^
wrong.idl:4:2: warning: #warning old
#warning old
 \\^
wrong.idl:5:2: error: #else after #else.*wrong.idl:7:1: error: unterminated #if
#if 1
\\^
" --check wrong.idl)
file(WRITE "${directory}/itself.idl" "#include \"itself.idl\"\n")
run(1 "^itself.idl:1:[0-9]+: error: #include goes too deep: does a file include itself" --check itself.idl)

# An error in an included file; tabs, a byte order mark, carriage returns, no end of the last line.
string(ASCII 239 187 191 mark)
file(WRITE "${directory}/main.idl" "${mark}typedef Zero A;\r\n#include \"part.idl\"\r\ntypedef\tOne\tB;")
file(WRITE "${directory}/part.idl" "\t/* ü */\t\tstruct S { Two x; };\n")
run(1 "^main.idl:1:9: error: there is no type 'Zero'\ntypedef Zero A;\n        \\^
part.idl:1:23: error: there is no type 'Two'
\t/\\* ü \\*/\t\tstruct S { Two x; };
\t       \t\t           \\^
main.idl:2:1: note: included from here
#include \"part.idl\"
\\^
main.idl:3:9: error: there is no type 'One'\ntypedef\tOne\tB;\n       \t\\^\n$" --check main.idl)

# Names as make wants them.
file(WRITE "${directory}/a file.idl" "#ifndef A\n#define A\ntypedef long A1;\n#endif A\n")
run(0 "^[.]/a\\\\ file.hpp ./a\\\\ file.cpp: [\\]\n  a\\\\ file.idl\n$" --emit deps "a file.idl")
run(0 "^$" -o "out put" --depfile "out $#.d" "a file.idl")
same("${directory}/out $#.d" "out\\ put/a\\ file.hpp out\\ put/a\\ file.cpp: \\\n  a\\ file.idl\n" "depfile")

# CORBA's own file is there without being a file, unless there is one.
file(WRITE "${directory}/orb_user.idl" "#include <orb.idl>\nstruct S { CORBA::TypeCode type; };\n")
run(0 "^x/orb_user.hpp x/orb_user.cpp: [\\]\n  orb_user.idl\n$" --emit deps -o x orb_user.idl)
run(0 "^$" -o "${WORK}/orb" orb_user.idl)
file(READ "${WORK}/orb/orb_user.hpp" generated)
if(generated MATCHES "orb.hpp\"")
    message(SEND_ERROR "what is generated includes orb.hpp:\n${generated}")
endif()
file(WRITE "${directory}/inc/orb.idl" "typedef long OfTheUser;\n")
run(0 "  inc/orb.idl\n$" --emit deps -I inc orb_user.idl)
