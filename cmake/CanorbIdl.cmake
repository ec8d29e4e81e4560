# canorb_target_idl(TARGET file.idl... [INCLUDES directory...])
#
# Generates C++ from each IDL file with canorb-idlc, compiles it into TARGET, and links TARGET to
# canorb. IDL files find what they #include in their own directory, in those of INCLUDES, and in
# those of all targets that TARGET is linked to. doc/cmake.md tells it all.
#
# The generated files are in ${CMAKE_CURRENT_BINARY_DIR}/idl/TARGET/, in the same folders as the
# IDL files are in the source directory. They are made again when an IDL file, one that it
# includes, or the compiler changes.
cmake_policy(PUSH)
cmake_policy(VERSION 3.20)

# The library's version: the compiler's must fit.
if(canorb_VERSION)
    set_property(GLOBAL PROPERTY CANORB_VERSION ${canorb_VERSION})
endif()

# What to run: CANORB_IDLC where it is set, cross-compiling the one that is found on this machine,
# else the one that belongs to the library.
function(_canorb_idl_compiler result)
    set(foreign FALSE)
    if(CMAKE_CROSSCOMPILING AND NOT CMAKE_CROSSCOMPILING_EMULATOR)
        set(foreign TRUE)
    endif()
    if(NOT CANORB_IDLC AND NOT foreign AND TARGET canorb::canorb-idlc)
        set(${result} canorb::canorb-idlc PARENT_SCOPE)
        return()
    endif()

    # What CMAKE_PREFIX_PATH and the root paths lead to is for the other machine.
    find_program(CANORB_IDLC canorb-idlc
        NO_PACKAGE_ROOT_PATH NO_CMAKE_PATH NO_CMAKE_ENVIRONMENT_PATH NO_CMAKE_FIND_ROOT_PATH
        DOC "The IDL compiler, a program of the machine that builds")
    if(NOT CANORB_IDLC)
        message(FATAL_ERROR "canorb_target_idl: there is no canorb-idlc to run on this machine. "
            "Build canorb for this machine, too, and say where its canorb-idlc is: "
            "-D CANORB_IDLC=/where/it/is/canorb-idlc, or put it into PATH.")
    endif()
    get_property(checked GLOBAL PROPERTY CANORB_IDLC_CHECKED)
    if(NOT checked STREQUAL CANORB_IDLC)
        execute_process(COMMAND ${CANORB_IDLC} --version
            RESULT_VARIABLE code OUTPUT_VARIABLE output ERROR_QUIET)
        if(NOT code EQUAL 0 OR NOT output MATCHES "^canorb-idlc ([0-9]+[.][0-9]+)")
            message(FATAL_ERROR "canorb_target_idl: CANORB_IDLC is '${CANORB_IDLC}', which is not "
                "a canorb-idlc that runs on this machine")
        endif()
        set(compiler_version ${CMAKE_MATCH_1})
        get_property(library_version GLOBAL PROPERTY CANORB_VERSION)
        if(NOT library_version MATCHES "^${compiler_version}([.]|$)")
            message(FATAL_ERROR "canorb_target_idl: ${CANORB_IDLC} is of version "
                "${compiler_version}, and canorb is ${library_version}: they do not fit together")
        endif()
        set_property(GLOBAL PROPERTY CANORB_IDLC_CHECKED ${CANORB_IDLC})
    endif()
    set(${result} ${CANORB_IDLC} PARENT_SCOPE)
endfunction()

# A path below the source or binary directory, or one of the directories given, relative to that;
# of another the name alone.
function(_canorb_idl_relative result path)
    foreach(root IN ITEMS "${CMAKE_CURRENT_BINARY_DIR}" "${CMAKE_CURRENT_SOURCE_DIR}" LISTS ARGN)
        file(RELATIVE_PATH relative "${root}" "${path}")
        if(NOT relative MATCHES "^[.][.](/|$)" AND NOT IS_ABSOLUTE "${relative}")
            set(${result} "${relative}" PARENT_SCOPE)
            return()
        endif()
    endforeach()
    get_filename_component(name "${path}" NAME)
    set(${result} "${name}" PARENT_SCOPE)
endfunction()

# What an earlier configuration generated must not be found any more.
function(_canorb_idl_remove_stale target directory)
    get_target_property(outputs ${target} CANORB_IDL_OUTPUTS)
    file(GLOB_RECURSE stale "${directory}/*.hpp" "${directory}/*.cpp")
    list(REMOVE_ITEM stale ${outputs})
    if(stale)
        file(REMOVE ${stale})
    endif()
endfunction()

# A place that sees the IDL directories of all that TARGET is linked to, privately too. They travel
# among the include directories, where only such a view sees them, not a C++ compiler.
function(_canorb_idl_view target)
    set(view ${target}.idl-view)
    if(TARGET ${view})
        return()
    endif()
    add_library(${view} INTERFACE)
    set_target_properties(${view} PROPERTIES
        CANORB_IDL_VIEW ON
        INTERFACE_LINK_LIBRARIES "$<TARGET_PROPERTY:${target},LINK_LIBRARIES>")
    # When all calls for this directory's targets are made.
    cmake_language(EVAL CODE "cmake_language(DEFER CALL _canorb_idl_remove_stale [[${target}]]
        [[${CMAKE_CURRENT_BINARY_DIR}/idl/${target}]])")
endfunction()

function(_canorb_idl_check_target target)
    if(NOT TARGET ${target})
        message(FATAL_ERROR "canorb_target_idl: there is no target '${target}'")
    endif()
    get_target_property(alias_of ${target} ALIASED_TARGET)
    if(alias_of)
        message(FATAL_ERROR "canorb_target_idl(${target}): this is an alias, name ${alias_of}")
    endif()
    get_target_property(type ${target} TYPE)
    if(NOT type MATCHES "^(STATIC_LIBRARY|SHARED_LIBRARY|MODULE_LIBRARY|OBJECT_LIBRARY|EXECUTABLE)$")
        message(FATAL_ERROR "canorb_target_idl(${target}): nothing is compiled into a target of the "
            "type ${type}. Make it a STATIC or OBJECT library, which others can be linked to.")
    endif()
    get_target_property(source_directory ${target} SOURCE_DIR)
    if(NOT source_directory STREQUAL CMAKE_CURRENT_SOURCE_DIR)
        message(FATAL_ERROR "canorb_target_idl(${target}): call it where the target is made, in "
            "${source_directory}: CMake knows how to generate files in one directory only")
    endif()
endfunction()

function(canorb_target_idl target)
    cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "INCLUDES")
    _canorb_idl_check_target(${target})
    if(NOT arg_UNPARSED_ARGUMENTS)
        message(FATAL_ERROR "canorb_target_idl(${target}): no IDL file given")
    endif()
    _canorb_idl_compiler(compiler)
    _canorb_idl_view(${target})
    set(directory "${CMAKE_CURRENT_BINARY_DIR}/idl/${target}")
    set(inherited "$<TARGET_PROPERTY:${target}.idl-view,INTERFACE_INCLUDE_DIRECTORIES>")
    set(inherited "$<REMOVE_DUPLICATES:${inherited}>")

    set(idl_directories)
    set(header_directories "${directory}")
    foreach(include IN LISTS arg_INCLUDES)
        get_filename_component(include "${include}" ABSOLUTE)
        list(APPEND idl_directories "${include}")
        file(RELATIVE_PATH relative "${CMAKE_CURRENT_SOURCE_DIR}" "${include}")
        if(relative AND NOT relative MATCHES "^[.][.](/|$)")
            list(APPEND header_directories "${directory}/${relative}")
        endif()
    endforeach()
    set(include_options ${idl_directories})
    list(TRANSFORM include_options PREPEND "-I")

    foreach(file IN LISTS arg_UNPARSED_ARGUMENTS)
        get_filename_component(path "${file}" ABSOLUTE)
        get_filename_component(path_directory "${path}" DIRECTORY)
        list(APPEND idl_directories "${path_directory}")
        _canorb_idl_relative(relative "${path}" ${idl_directories})
        get_filename_component(stem "${relative}" NAME_WLE)
        get_filename_component(output_directory "${directory}/${relative}" DIRECTORY)
        list(APPEND header_directories "${output_directory}")
        set(output "${output_directory}/${stem}")
        get_target_property(outputs ${target} CANORB_IDL_OUTPUTS)
        if("${output}.hpp" IN_LIST outputs)
            message(FATAL_ERROR "canorb_target_idl(${target}): two files would be compiled to "
                "${output}.hpp. The second is ${path}")
        endif()
        set(touch_outputs)
        if(NOT CMAKE_GENERATOR MATCHES "Ninja")
            # canorb-idlc leaves alone what does not change: only Ninja does not try again then.
            set(touch_outputs
                COMMAND "${CMAKE_COMMAND}" -E touch "${output}.hpp" "${output}.cpp")
        endif()
        add_custom_command(
            OUTPUT "${output}.hpp" "${output}.cpp"
            COMMAND ${compiler} --output-dir "${output_directory}" --depfile "${output}.d"
                ${include_options} "$<$<BOOL:${inherited}>:-I$<JOIN:${inherited},;-I>>" "${path}"
            ${touch_outputs}
            DEPENDS "${path}" ${compiler}
            DEPFILE "${output}.d"
            COMMENT "Compiling ${relative} for ${target}"
            VERBATIM COMMAND_EXPAND_LISTS)
        target_sources(${target} PRIVATE "${output}.hpp" "${output}.cpp")
        set_property(TARGET ${target} APPEND PROPERTY
            CANORB_IDL_OUTPUTS "${output}.hpp" "${output}.cpp")
    endforeach()

    list(REMOVE_DUPLICATES idl_directories)
    list(REMOVE_DUPLICATES header_directories)
    get_target_property(type ${target} TYPE)
    set(scope PUBLIC)
    if(type STREQUAL "EXECUTABLE")
        set(scope PRIVATE)
    endif()
    # A layer of canorb itself says what it links, and is included as <canorb/...> alone.
    get_target_property(is_layer ${target} CANORB_LAYER)
    if(is_layer)
        set(header_directories "${directory}")
    else()
        target_link_libraries(${target} ${scope} canorb::canorb)
    endif()
    target_include_directories(${target} ${scope} "$<BUILD_INTERFACE:${header_directories}>")
    target_include_directories(${target} INTERFACE
        "$<BUILD_INTERFACE:$<$<BOOL:$<TARGET_PROPERTY:CANORB_IDL_VIEW>>:${idl_directories}>>")
    target_include_directories(${target}.idl-view INTERFACE ${idl_directories})
    # canorb's own build compiles what it generates as strictly as what it writes.
    if(TARGET canorb_warnings)
        target_link_libraries(${target} PRIVATE $<BUILD_INTERFACE:canorb_warnings>)
    endif()
endfunction()

cmake_policy(POP)
