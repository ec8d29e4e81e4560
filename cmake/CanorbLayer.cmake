# canorb_add_layer(NAME SOURCES file... [LINKS target...])
#
# One layer of the ORB: a static library canorb_NAME, alias canorb::NAME. With no sources it is an
# interface library. LINKS names the layers below that it may include, and nothing else.
add_library(canorb_options INTERFACE)
target_compile_features(canorb_options INTERFACE cxx_std_20)

add_library(canorb_warnings INTERFACE)
target_compile_options(canorb_warnings INTERFACE
    -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wsign-conversion -Wold-style-cast
    -Wnon-virtual-dtor -Woverloaded-virtual -Wcast-align -Wformat=2 -Wnull-dereference)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # gcc 12 reports these wrongly in inlined standard library code (std::vector, std::variant).
    target_compile_options(canorb_warnings INTERFACE -Wno-null-dereference -Wno-maybe-uninitialized
        -Wno-array-bounds -Wno-stringop-overflow -Wno-stringop-overread -Wno-restrict)
endif()
if(CANORB_WERROR)
    target_compile_options(canorb_warnings INTERFACE -Werror)
endif()

if(CANORB_SANITIZE)
    add_compile_options(-fsanitize=${CANORB_SANITIZE} -fno-omit-frame-pointer
        -fno-sanitize-recover=all)
    add_link_options(-fsanitize=${CANORB_SANITIZE})
endif()

if(CANORB_BUILD_FUZZERS)
    if(NOT CMAKE_CXX_COMPILER_ID STREQUAL "Clang" OR NOT CANORB_SANITIZE)
        message(FATAL_ERROR "CANORB_BUILD_FUZZERS needs clang and CANORB_SANITIZE, see preset asan")
    endif()
    add_compile_options(-fsanitize=fuzzer-no-link)
endif()

set_property(GLOBAL PROPERTY CANORB_LAYERS "")

function(canorb_add_layer name)
    cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;LINKS")
    set(target canorb_${name})
    if(arg_SOURCES)
        add_library(${target} STATIC ${arg_SOURCES})
        set(scope PUBLIC)
        target_link_libraries(${target} PRIVATE $<BUILD_INTERFACE:canorb_warnings>)
        set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON)
    else()
        add_library(${target} INTERFACE)
        set(scope INTERFACE)
    endif()
    add_library(canorb::${name} ALIAS ${target})
    set_target_properties(${target} PROPERTIES EXPORT_NAME ${name} CANORB_LAYER ON)
    target_include_directories(${target} ${scope}
        $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
        $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/canorb/impl>)
    target_link_libraries(${target} ${scope} canorb_options ${arg_LINKS})
    set_property(GLOBAL APPEND PROPERTY CANORB_LAYERS ${target})
endfunction()
