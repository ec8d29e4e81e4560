#pragma once

#include <string>
#include <string_view>

#include "operator_line.hpp"

namespace tank {

/// A file descriptor, closed at the end.
class FileDescriptor {
  public:
    explicit FileDescriptor(int number) : number_(number) {}
    ~FileDescriptor();
    FileDescriptor(const FileDescriptor&) = delete;
    FileDescriptor& operator=(const FileDescriptor&) = delete;

    int number() const { return number_; }

  private:
    int number_;
};

/// Makes a terminal a plain line, 115200 baud, 8 data bits, no parity, 1 stop bit, that changes
/// nothing and answers nothing. Throws std::system_error.
void set_raw_115200_8n1(int file_descriptor);

/// The serial line to the operator station as a pseudo-terminal: any terminal program can open
/// path(), leave, and come again. Text is lost while nobody is there, or nobody reads.
class SerialTerminal final : public OperatorLine {
  public:
    /// Throws std::system_error.
    SerialTerminal();

    const std::string& path() const { return path_; }

    std::optional<char> read() override;
    void write(std::string_view text) override;

  private:
    FileDescriptor master_;
    std::string path_;
    bool line_broken_ = false;
};

}  // namespace tank
