#include "line_reader.hpp"

#include <poll.h>
#include <unistd.h>

#include <array>
#include <cerrno>

namespace plant {

void LineReader::read(const std::function<void(std::string_view)>& take) {
    constexpr std::size_t longest_line = 4096;
    pollfd waiting{.fd = file_descriptor_, .events = POLLIN, .revents = 0};
    while (!at_end_ && ::poll(&waiting, 1, 0) > 0) {
        std::array<char, 1024> buffer;
        const ssize_t count = ::read(file_descriptor_, buffer.data(), buffer.size());
        if (count < 0 && (errno == EINTR || errno == EAGAIN)) return;
        if (count <= 0) {
            at_end_ = end_ == End::final;
            return;
        }
        rest_.append(buffer.data(), static_cast<std::size_t>(count));
        std::size_t end = 0;
        while ((end = rest_.find('\n')) != std::string::npos) {
            const std::string line = rest_.substr(0, end);
            rest_.erase(0, end + 1);
            take(line);
        }
        if (rest_.size() > longest_line) rest_.clear();
    }
}

}  // namespace plant
