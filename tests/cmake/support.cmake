# Functions for the tests of this folder. WORK is a directory of the test's own; project/ is copied
# there, because its files are changed.
cmake_minimum_required(VERSION 3.25)

file(REMOVE_RECURSE "${WORK}")
file(COPY "${CMAKE_CURRENT_LIST_DIR}/project" DESTINATION "${WORK}")
set(source "${WORK}/project")
set(build "${WORK}/build tree")

set(options -D "CMAKE_CXX_COMPILER=${COMPILER}" -D CMAKE_BUILD_TYPE=Debug
    -D "CMAKE_CXX_FLAGS_DEBUG=-O0 -Wall -Wextra -Wconversion -Werror")
if(LAUNCHER)
    list(APPEND options -D "CMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER}")
endif()

# run(command...): it must succeed; what it writes is in `output`.
macro(run)
    message(STATUS "${ARGV}")
    execute_process(COMMAND ${ARGV} RESULT_VARIABLE code OUTPUT_VARIABLE output ERROR_VARIABLE output)
    if(NOT code EQUAL 0)
        message(FATAL_ERROR "exit code ${code}:\n${output}")
    endif()
endmacro()

# Builds the target and checks that exactly these IDL files are compiled, "file for target" each.
function(expect_compiled target)
    run(${CMAKE_COMMAND} --build "${build}" --target ${target} -j 2)
    string(REGEX MATCHALL "Compiling [^\n]*[.]idl for [a-z]+" compiled "${output}")
    list(TRANSFORM compiled REPLACE "^Compiling " "")
    list(SORT compiled)
    set(expected ${ARGN})
    list(SORT expected)
    if(NOT "${compiled}" STREQUAL "${expected}")
        message(FATAL_ERROR "compiled: ${compiled}\nexpected: ${expected}\n${output}")
    endif()
endfunction()

# What must hold with every generator, once everything is generated.
function(check_rebuilds)
    expect_compiled(generated)
    # An included file changes: what includes it is compiled again, the rest is not.
    file(APPEND "${source}/shared idl/common/units.idl" "// One more line.\n")
    expect_compiled(generated
        "shared idl/common/units.idl for units" "device.idl for device"
        "panel.idl for panel" "panel.idl for program" "pump.idl for program")
    expect_compiled(generated)
    file(APPEND "${source}/pump.idl" "// One more line.\n")
    expect_compiled(generated "pump.idl for program")
    expect_compiled(generated)
    # The include goes, and with it the dependency.
    file(WRITE "${source}/pump.idl" "module Plant { struct Pump { long speed; }; };\n")
    expect_compiled(generated "pump.idl for program")
    file(APPEND "${source}/alarm.idl" "// One more line.\n")
    expect_compiled(generated "alarm.idl for alarm")
endfunction()
