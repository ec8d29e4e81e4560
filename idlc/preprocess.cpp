#include "idlc/preprocess.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string_view>

#include "idlc/preprocessor_messages.hpp"

extern char** environ;

namespace canorb::idlc {

namespace {

struct CloseFile {
    void operator()(std::FILE* file) const { std::fclose(file); }
};
using TemporaryFile = std::unique_ptr<std::FILE, CloseFile>;

using Words = std::vector<std::string>;

/// The same preprocessor by any other name; the first that is installed is used.
const Words programs[] = {{"cpp"}, {"gcc", "-E"}, {"clang", "-E"}};

std::string content(std::FILE* file) {
    std::string text;
    std::array<char, 65536> buffer{};
    std::rewind(file);
    while (const std::size_t read = std::fread(buffer.data(), 1, buffer.size(), file)) {
        text.append(buffer.data(), read);
    }
    return text;
}

/// What CORBA wants of orb.idl, apart from what the compiler knows itself and from valuetypes. For
/// C++ the same is in <canorb/corba.hpp>.
constexpr std::string_view orb_idl = R"(#ifndef CANORB_ORB_IDL
#define CANORB_ORB_IDL
#pragma prefix "omg.org"
module CORBA {
  typedef string Identifier;
  typedef string RepositoryId;
  typedef string ScopedName;
  typedef string VersionSpec;
  typedef sequence<any> AnySeq;
  typedef sequence<boolean> BooleanSeq;
  typedef sequence<char> CharSeq;
  typedef sequence<wchar> WCharSeq;
  typedef sequence<octet> OctetSeq;
  typedef sequence<short> ShortSeq;
  typedef sequence<unsigned short> UShortSeq;
  typedef sequence<long> LongSeq;
  typedef sequence<unsigned long> ULongSeq;
  typedef sequence<long long> LongLongSeq;
  typedef sequence<unsigned long long> ULongLongSeq;
  typedef sequence<float> FloatSeq;
  typedef sequence<double> DoubleSeq;
  typedef sequence<long double> LongDoubleSeq;
  typedef sequence<string> StringSeq;
  typedef sequence<wstring> WStringSeq;
};
#endif
)";

/// A directory with the file that CORBA has include for the types of module CORBA.
class OwnFiles {
  public:
    OwnFiles() {
        std::error_code error;
        std::string name = std::filesystem::temp_directory_path(error) / "canorb-idlc-XXXXXX";
        if (error || mkdtemp(name.data()) == nullptr) return;
        directory_ = name;
        std::ofstream{file()} << orb_idl;
    }
    ~OwnFiles() {
        std::error_code ignored;
        if (!directory_.empty()) std::filesystem::remove_all(directory_, ignored);
    }
    OwnFiles(const OwnFiles&) = delete;
    OwnFiles& operator=(const OwnFiles&) = delete;

    /// Empty: it could not be made.
    const std::string& directory() const { return directory_; }

    /// In linemarkers the file has a name that is no file's.
    void rename_in(std::string& text) const {
        if (directory_.empty()) return;
        const std::string from = '"' + file() + '"';
        for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos;) {
            text.replace(at, from.size(), "\"<orb.idl>\"");
        }
    }

  private:
    std::string file() const { return directory_ + "/orb.idl"; }

    std::string directory_;
};

Words arguments(const std::string& file, const PreprocessorOptions& options,
                const OwnFiles& own_files) {
    // -undef: `linux` and `unix` are good names in IDL. -dI: keeps the #include lines, which say
    // how a file is spelled. -ftabstop: columns in its messages count a tab as one. IDL has no
    // trigraphs.
    Words words{"-x", "c", "-C", "-undef", "-nostdinc", "-dI", "-ftabstop=1", "-Wno-trigraphs"};
    for (const std::string& directory : options.include_directories) {
        words.push_back("-I");
        words.push_back(directory);
    }
    for (const std::string& macro : options.macros) {
        words.push_back("-D");
        words.push_back(macro);
    }
    if (!own_files.directory().empty()) {
        words.push_back("-idirafter");
        words.push_back(own_files.directory());
    }
    // A file called -x is a file.
    words.push_back(file.starts_with('-') ? "./" + file : file);
    return words;
}

/// This process's, but for what changes how the preprocessor speaks, or where it looks.
Words environment() {
    constexpr std::string_view unwanted[] = {
        "LC_ALL=", "LANGUAGE=", "CPATH=", "C_INCLUDE_PATH=", "DEPENDENCIES_OUTPUT="};
    Words variables{"LC_ALL=C"};
    for (char** variable = environ; *variable != nullptr; ++variable) {
        const std::string_view text = *variable;
        const bool drop =
            std::any_of(std::begin(unwanted), std::end(unwanted),
                        [&](std::string_view name) { return text.starts_with(name); });
        if (!drop) variables.emplace_back(text);
    }
    return variables;
}

std::vector<char*> pointers(Words& words) {
    std::vector<char*> result;
    for (std::string& word : words) result.push_back(word.data());
    result.push_back(nullptr);
    return result;
}

/// Runs the command with standard output and error into the files; its exit code, or -errno.
int run(Words words, std::FILE* output, std::FILE* errors) {
    Words variables = environment();
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_adddup2(&actions, fileno(output), STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&actions, fileno(errors), STDERR_FILENO);
    pid_t child = 0;
    const int failed = posix_spawnp(&child, words.front().c_str(), &actions, nullptr,
                                    pointers(words).data(), pointers(variables).data());
    posix_spawn_file_actions_destroy(&actions);
    if (failed != 0) return -failed;

    int status = 0;
    while (waitpid(child, &status, 0) < 0) {
        if (errno != EINTR) return -errno;
    }
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128;
}

}  // namespace

Preprocessed preprocess(const std::string& file, const PreprocessorOptions& options) {
    Preprocessed result;
    // Files, not pipes: two pipes would need two readers at once.
    const TemporaryFile output{std::tmpfile()};
    const TemporaryFile errors{std::tmpfile()};
    if (!output || !errors) {
        result.message =
            std::string{"cannot make a temporary file: "} + std::strerror(errno) + '\n';
        return result;
    }
    const OwnFiles own_files;
    int code = -ENOENT;
    for (Words words : programs) {
        const Words more = arguments(file, options, own_files);
        words.insert(words.end(), more.begin(), more.end());
        code = run(std::move(words), output.get(), errors.get());
        if (code != -ENOENT) break;
    }
    if (code < 0) {
        result.message = std::string{"cannot run the C preprocessor 'cpp': "} +
                         std::strerror(-code) + " (on Debian: apt install cpp)\n";
        return result;
    }
    result.ok = code == 0;
    result.text = content(output.get());
    own_files.rename_in(result.text);
    result.message = preprocessor_messages(content(errors.get()), options.include_directories);
    if (!result.ok && result.message.empty()) {
        result.message = file + ": the C preprocessor failed, and does not say why\n";
    }
    return result;
}

}  // namespace canorb::idlc
