# Installs the library, its headers, the programs and the CMake package that
# find_package(canorb) finds. Only include/canorb/*.hpp is promised to users; the layers' own
# headers, which those include, go below include/canorb/impl.
include(CMakePackageConfigHelpers)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/canorb)

get_property(layers GLOBAL PROPERTY CANORB_LAYERS)
install(TARGETS canorb canorb_options ${layers} EXPORT canorbTargets
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
    INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
# In a file of its own: where the library is for another machine, the compiler is not with it.
if(TARGET canorb-idlc)
    install(TARGETS canorb-idlc EXPORT canorbIdlcTargets
        RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
    install(EXPORT canorbIdlcTargets NAMESPACE canorb:: DESTINATION ${package_dir})
endif()
if(CANORB_BUILD_TOOLS)
    install(TARGETS canorb-bits canorb-bus canorb-console RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()

install(DIRECTORY ${PROJECT_SOURCE_DIR}/orb/include/canorb/
    DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/canorb
    FILES_MATCHING PATTERN "*.hpp" PATTERN "*.idl")
get_target_property(generated canorb_services CANORB_IDL_OUTPUTS)
list(FILTER generated INCLUDE REGEX "[.]hpp$")
install(FILES ${generated} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/canorb)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/orb
    DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/canorb/impl
    FILES_MATCHING PATTERN "*.hpp" PATTERN include EXCLUDE)

install(EXPORT canorbTargets NAMESPACE canorb:: DESTINATION ${package_dir})
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/canorbConfig.cmake.in
    ${PROJECT_BINARY_DIR}/canorbConfig.cmake INSTALL_DESTINATION ${package_dir})
# Before 1.0 a minor version may change anything.
write_basic_package_version_file(${PROJECT_BINARY_DIR}/canorbConfigVersion.cmake
    COMPATIBILITY SameMinorVersion)
install(FILES
    ${PROJECT_BINARY_DIR}/canorbConfig.cmake
    ${PROJECT_BINARY_DIR}/canorbConfigVersion.cmake
    ${PROJECT_SOURCE_DIR}/cmake/CanorbIdl.cmake
    DESTINATION ${package_dir})
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})

# The build directory is a package, too, for -D canorb_DIR=DIRECTORY.
export(TARGETS canorb canorb_options canorb_warnings ${layers} NAMESPACE canorb::
    FILE ${PROJECT_BINARY_DIR}/canorbTargets.cmake)
if(TARGET canorb-idlc)
    export(TARGETS canorb-idlc NAMESPACE canorb:: FILE ${PROJECT_BINARY_DIR}/canorbIdlcTargets.cmake)
endif()
configure_file(${PROJECT_SOURCE_DIR}/cmake/CanorbIdl.cmake ${PROJECT_BINARY_DIR}/CanorbIdl.cmake
    COPYONLY)
