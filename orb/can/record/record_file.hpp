#pragma once

#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <string_view>

#include "orb/base/result.hpp"

namespace canorb::can {

/// A file that a recording goes to. What is appended is gathered and written in whole pieces, so
/// that what is in the file ends with a whole record whenever the program is killed.
///
/// Not safe for use by two threads at once.
class RecordFile {
  public:
    /// Makes the file, or empties it. The error is a sentence for people.
    static Result<RecordFile, std::string> create(const std::string& path);

    RecordFile(RecordFile&&) = default;
    RecordFile& operator=(RecordFile&&) = delete;
    ~RecordFile();

    /// Appends a whole record. It is in the file at the latest with the next flush().
    void append(std::string_view record);

    /// Writes over what is in the file at `offset`, now. Only for files that are seekable().
    void overwrite(std::uint64_t offset, std::string_view text);

    void flush();

    bool seekable() const { return seekable_; }

    /// What went wrong first, a sentence for people; empty when nothing did. From then on, without
    /// room on the disk for example, everything is lost.
    const std::string& error() const { return error_; }

  private:
    struct Closer {
        void operator()(std::FILE* file) const { std::fclose(file); }
    };
    using File = std::unique_ptr<std::FILE, Closer>;

    RecordFile(std::string path, File file);
    void write(std::string_view text);
    bool seek(std::uint64_t offset, int origin);
    void fail();

    std::string path_;
    File file_;
    bool seekable_;
    std::string gathered_;
    std::string error_;
};

}  // namespace canorb::can
