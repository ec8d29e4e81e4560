#pragma once

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>

#include "tests/can/temporary_directory.hpp"

namespace canorb::can {

/// A test that writes a recording to a file and reads it.
class RecordTest : public testing::Test {
  protected:
    std::string path() const { return directory_.path() + "/record"; }

    std::string content() const {
        std::ifstream file{path(), std::ios::binary};
        return {std::istreambuf_iterator<char>(file), {}};
    }

  private:
    test::TemporaryDirectory directory_;
};

}  // namespace canorb::can
