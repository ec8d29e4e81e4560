# Installs canorb into WORK_DIR, then configures, builds and runs the project in SOURCE_DIR against
# it. The space in the path is on purpose.
cmake_minimum_required(VERSION 3.25)

set(prefix "${WORK_DIR}/an installed canorb")
set(build "${WORK_DIR}/build")

function(run)
    execute_process(COMMAND ${ARGV} COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
endfunction()

file(REMOVE_RECURSE "${WORK_DIR}")
run(${CMAKE_COMMAND} --install "${BUILD_DIR}" --prefix "${prefix}")

set(options -D "CMAKE_PREFIX_PATH=${prefix}" -D "CMAKE_CXX_COMPILER=${COMPILER}")
if(LAUNCHER)
    list(APPEND options -D "CMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER}")
endif()
run(${CMAKE_COMMAND} -S "${SOURCE_DIR}" -B "${build}" -G "${GENERATOR}" ${options})
run(${CMAKE_COMMAND} --build "${build}")
run("${build}/pump")
