#include "orb/can/record/record_file.hpp"

#include <cerrno>
#include <system_error>
#include <utility>

namespace canorb::can {
namespace {

constexpr std::size_t gathered_octets = 64 * 1024;

std::string reason(int error_number) {
    return std::system_category().message(error_number);
}

}  // namespace

Result<RecordFile, std::string> RecordFile::create(const std::string& path) {
    File file{std::fopen(path.c_str(), "wb")};
    if (!file) return Failure{"cannot write " + path + ": " + reason(errno)};
    // It gathers records itself: a buffer of stdio would be written in pieces of any size.
    std::setvbuf(file.get(), nullptr, _IONBF, 0);
    return RecordFile{path, std::move(file)};
}

RecordFile::RecordFile(std::string path, File file)
    : path_(std::move(path)),
      file_(std::move(file)),
      seekable_(std::fseek(file_.get(), 0, SEEK_CUR) == 0) {}

RecordFile::~RecordFile() {
    if (file_) flush();
}

void RecordFile::append(std::string_view record) {
    if (!error_.empty()) return;
    gathered_ += record;
    if (gathered_.size() >= gathered_octets) flush();
}

void RecordFile::flush() {
    if (gathered_.empty()) return;
    write(gathered_);
    gathered_.clear();
}

void RecordFile::overwrite(std::uint64_t offset, std::string_view text) {
    flush();
    if (!error_.empty() || !seek(offset, SEEK_SET)) return;
    write(text);
    if (error_.empty()) seek(0, SEEK_END);
}

void RecordFile::write(std::string_view text) {
    while (!text.empty() && error_.empty()) {
        errno = 0;
        text.remove_prefix(std::fwrite(text.data(), 1, text.size(), file_.get()));
        if (text.empty()) return;
        if (errno != EINTR) fail();
        std::clearerr(file_.get());
    }
}

bool RecordFile::seek(std::uint64_t offset, int origin) {
    if (std::fseek(file_.get(), static_cast<long>(offset), origin) == 0) return true;
    fail();
    return false;
}

void RecordFile::fail() {
    error_ = "cannot write all of " + path_ + ": " + reason(errno);
    gathered_.clear();
}

}  // namespace canorb::can
