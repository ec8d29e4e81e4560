# canorb as a subdirectory, and as a package, of what is built for another machine. It is this
# machine's compiler that pretends.
include(${CMAKE_CURRENT_LIST_DIR}/support.cmake)

file(WRITE "${WORK}/toolchain.cmake"
    "set(CMAKE_SYSTEM_NAME Generic)\nset(CMAKE_SYSTEM_PROCESSOR other)\n"
    "set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)\nset(CMAKE_FIND_ROOT_PATH \"${WORK}\")\n")
list(APPEND options -D "CMAKE_TOOLCHAIN_FILE=${WORK}/toolchain.cmake"
    -D "canorb_DIR=${CANORB_BUILD_DIR}")

# Without a canorb-idlc of this machine it is said what is missing.
set(ENV{PATH} "/usr/bin:/bin")
execute_process(COMMAND ${CMAKE_COMMAND} -S "${source}" -B "${build}" ${options}
    RESULT_VARIABLE code OUTPUT_VARIABLE output ERROR_VARIABLE output)
if(code EQUAL 0 OR NOT output MATCHES "CANORB_IDLC=/where")
    message(FATAL_ERROR "exit code ${code}:\n${output}")
endif()

run(${CMAKE_COMMAND} -S "${source}" -B "${build}" ${options} -D "CANORB_IDLC=${IDLC}")
expect_compiled(generated
    "shared idl/common/units.idl for units" "device.idl for device" "alarm.idl for alarm"
    "panel.idl for panel" "panel.idl for program" "pump.idl for program")
expect_compiled(generated)

# In PATH it is found.
get_filename_component(directory "${IDLC}" DIRECTORY)
set(ENV{PATH} "${directory}:$ENV{PATH}")
run(${CMAKE_COMMAND} -S "${source}" -B "${build}" -U CANORB_IDLC)
expect_compiled(generated)

set(build "${WORK}/below")
run(${CMAKE_COMMAND} -S "${source}" -B "${build}" ${options}
    -D "CANORB_IDLC=${IDLC}" -D "CANORB_SUBDIRECTORY=${CANORB_SOURCE_DIR}")
expect_compiled(generated
    "shared idl/common/units.idl for units" "device.idl for device" "alarm.idl for alarm"
    "panel.idl for panel" "panel.idl for program" "pump.idl for program")
