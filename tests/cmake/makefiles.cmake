include(${CMAKE_CURRENT_LIST_DIR}/support.cmake)

find_program(make NAMES make gmake)
if(NOT make)
    message("SKIPPED: there is no make")
    return()
endif()
run(${CMAKE_COMMAND} -S "${source}" -B "${build}" -G "Unix Makefiles"
    -D "canorb_DIR=${CANORB_BUILD_DIR}" ${options})
# All but the C++: the same is compiled with Ninja.
expect_compiled(generated
    "shared idl/common/units.idl for units" "device.idl for device" "alarm.idl for alarm"
    "panel.idl for panel" "panel.idl for program" "pump.idl for program")
check_rebuilds()
# One library, by its own rule.
run(${CMAKE_COMMAND} --build "${build}" --target units)
expect_compiled(units)
