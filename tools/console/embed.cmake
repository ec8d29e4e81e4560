# cmake -D INPUT=FILE -D OUTPUT=FILE -P embed.cmake: a text as the initializer of a std::string_view.
file(READ "${INPUT}" text)
# Compilers need not take longer literals than this many octets in one piece.
set(limit 8000)
set(pieces "")
string(LENGTH "${text}" length)
set(at 0)
while(at LESS length)
    string(SUBSTRING "${text}" ${at} ${limit} piece)
    string(APPEND pieces "R\"canorb(${piece})canorb\"\n")
    math(EXPR at "${at} + ${limit}")
endwhile()
file(WRITE "${OUTPUT}" "${pieces}")
