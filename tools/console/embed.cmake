# cmake -D INPUT=FILE -D OUTPUT=FILE -P embed.cmake: makes node_idl.cpp from the compiler's JSON.
file(READ "${INPUT}" text)
# Compilers need not take longer literals than this many octets in one piece.
set(limit 8000)
set(pieces "")
string(LENGTH "${text}" length)
set(at 0)
while(at LESS length)
    string(SUBSTRING "${text}" ${at} ${limit} piece)
    string(APPEND pieces "\n    R\"canorb(${piece})canorb\"")
    math(EXPR at "${at} + ${limit}")
endwhile()
file(WRITE "${OUTPUT}" "#include \"tools/console/node_idl.hpp\"

namespace canorb::console {

const std::string_view node_idl_json =${pieces};

}  // namespace canorb::console
")
