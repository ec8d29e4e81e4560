#include "footprint.hpp"

#include <elf.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <stdexcept>

namespace peers {

namespace {

struct Sizes {
    std::uint64_t text = 0;
    std::uint64_t data = 0;
    std::uint64_t bss = 0;
};

template <typename Structure>
Structure read_structure(std::ifstream& file, std::uint64_t offset) {
    Structure structure;
    file.seekg(static_cast<std::streamoff>(offset));
    file.read(reinterpret_cast<char*>(&structure), sizeof(structure));
    if (!file) throw std::runtime_error("an ELF file ends too soon");
    return structure;
}

/// As size(1) has it: what is loaded but never written counts as text.
Sizes section_sizes(const std::filesystem::path& path) {
    std::ifstream file{path, std::ios::binary};
    const auto header = read_structure<Elf64_Ehdr>(file, 0);
    if (std::memcmp(header.e_ident, ELFMAG, SELFMAG) != 0 ||
        header.e_ident[EI_CLASS] != ELFCLASS64 || header.e_shentsize != sizeof(Elf64_Shdr)) {
        throw std::runtime_error("not a 64-bit ELF file: " + path.string());
    }
    Sizes sizes;
    for (std::uint64_t i = 0; i < header.e_shnum; ++i) {
        const auto section =
            read_structure<Elf64_Shdr>(file, header.e_shoff + i * sizeof(Elf64_Shdr));
        if ((section.sh_flags & SHF_ALLOC) == 0) continue;
        if (section.sh_type == SHT_NOBITS) {
            sizes.bss += section.sh_size;
        } else if ((section.sh_flags & SHF_WRITE) != 0) {
            sizes.data += section.sh_size;
        } else {
            sizes.text += section.sh_size;
        }
    }
    return sizes;
}

nlohmann::ordered_json to_json(const std::filesystem::path& path, const Sizes& sizes) {
    return {{"name", path.filename().string()},
            {"text", sizes.text},
            {"data", sizes.data},
            {"bss", sizes.bss}};
}

/// The ELF files that the process has mapped to run code from.
std::set<std::filesystem::path> mapped_files(pid_t pid) {
    std::set<std::filesystem::path> files;
    std::ifstream maps{"/proc/" + std::to_string(pid) + "/maps"};
    for (std::string line; std::getline(maps, line);) {
        std::istringstream fields{line};
        std::string addresses, permissions, offset, device, inode, path;
        fields >> addresses >> permissions >> offset >> device >> inode >> path;
        if (permissions.find('x') != std::string::npos && path.starts_with('/')) {
            files.insert(path);
        }
    }
    if (files.empty()) throw std::runtime_error("the server's memory cannot be read");
    return files;
}

std::uint64_t memory_octets(pid_t pid, const std::string& field) {
    std::ifstream status{"/proc/" + std::to_string(pid) + "/status"};
    for (std::string line; std::getline(status, line);) {
        if (line.starts_with(field + ":")) return std::stoull(line.substr(field.size() + 1)) * 1024;
    }
    throw std::runtime_error("the kernel does not tell " + field);
}

}  // namespace

nlohmann::ordered_json footprint(pid_t pid, const std::vector<std::string>& peer) {
    const auto program = std::filesystem::read_symlink("/proc/" + std::to_string(pid) + "/exe");
    nlohmann::ordered_json result;
    auto own = nlohmann::ordered_json::array();
    auto others = nlohmann::ordered_json::array();
    Sizes total = section_sizes(program);
    result["program"] = to_json(program, total);
    std::size_t found = 0;
    for (const auto& file : mapped_files(pid)) {
        if (file == program) continue;
        const std::string name = file.filename().string();
        const Sizes sizes = section_sizes(file);
        const bool is_own = std::any_of(peer.begin(), peer.end(), [&](const std::string& start) {
            return name.starts_with(start);
        });
        (is_own ? own : others).push_back(to_json(file, sizes));
        if (!is_own) continue;
        ++found;
        total.text += sizes.text;
        total.data += sizes.data;
        total.bss += sizes.bss;
    }
    if (found < peer.size()) throw std::runtime_error("a library of the peer is not loaded");
    result["peer_libraries"] = own;
    result["other_libraries"] = others;
    result["text_and_data"] = total.text + total.data;  // program and the peer's libraries
    result["bss"] = total.bss;
    result["peak_memory"] = memory_octets(pid, "VmHWM");
    result["anonymous_memory"] = memory_octets(pid, "RssAnon");
    return result;
}

}  // namespace peers
