# canorb_target_idl(TARGET file.idl... [INCLUDES directory...])
#
# Generates C++ from each IDL file with canorb-idlc, compiles it into TARGET, and lets TARGET find
# the headers as "file.hpp". INCLUDES names directories where IDL files find what they #include;
# the directory of each file is among them anyway. TARGET is linked to canorb.
#
# The generated files are in ${CMAKE_CURRENT_BINARY_DIR}/idl/TARGET/ and are made again when an IDL
# file, one that it includes, or the compiler changes.
function(canorb_target_idl target)
    cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "INCLUDES")
    if(NOT TARGET ${target})
        message(FATAL_ERROR "canorb_target_idl: there is no target '${target}'")
    endif()
    if(NOT arg_UNPARSED_ARGUMENTS)
        message(FATAL_ERROR "canorb_target_idl(${target}): no IDL file given")
    endif()
    set(directory ${CMAKE_CURRENT_BINARY_DIR}/idl/${target})
    set(include_options)
    foreach(include IN LISTS arg_INCLUDES)
        get_filename_component(include ${include} ABSOLUTE)
        list(APPEND include_options -I ${include})
    endforeach()

    foreach(file IN LISTS arg_UNPARSED_ARGUMENTS)
        get_filename_component(path ${file} ABSOLUTE)
        get_filename_component(stem ${file} NAME_WLE)
        add_custom_command(
            OUTPUT ${directory}/${stem}.hpp ${directory}/${stem}.cpp
            COMMAND canorb::canorb-idlc --output-dir ${directory}
                --depfile ${directory}/${stem}.d ${include_options} ${path}
            DEPENDS ${path} canorb::canorb-idlc
            DEPFILE ${directory}/${stem}.d
            COMMENT "Compiling ${file}"
            VERBATIM)
        target_sources(${target} PRIVATE ${directory}/${stem}.hpp ${directory}/${stem}.cpp)
    endforeach()

    get_target_property(type ${target} TYPE)
    set(scope PUBLIC)
    if(type STREQUAL "EXECUTABLE")
        set(scope PRIVATE)
    endif()
    target_include_directories(${target} ${scope} $<BUILD_INTERFACE:${directory}>)
    target_link_libraries(${target} ${scope} canorb::canorb)
    # canorb's own build compiles what it generates as strictly as what it writes.
    if(TARGET canorb_warnings)
        target_link_libraries(${target} PRIVATE $<BUILD_INTERFACE:canorb_warnings>)
    endif()
endfunction()
