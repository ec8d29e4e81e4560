// How much software a process is: its program and libraries by the sections of their ELF files,
// and its memory.
#pragma once

#include <sys/types.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace peers {

/// The program and the libraries that PID has mapped: text (code and constants), data and bss, as
/// size(1) counts them. Libraries whose file names begin with one of PEER are the peer's own, the
/// others are those that the peer, C++ and C bring. Also the peak of the process's memory.
nlohmann::ordered_json footprint(pid_t pid, const std::vector<std::string>& peer);

}  // namespace peers
