// Whole files: what the compiler says of wrong ones, how it reads right ones, and what it generates
// for them.

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "idlc/emit/emit.hpp"
#include "idlc/lexer.hpp"
#include "idlc/parse/parser.hpp"
#include "tests/idlc/support.hpp"

namespace canorb::idlc::test {
namespace {

class FileTest : public testing::TestWithParam<std::string> {
  protected:
    void SetUp() override { std::filesystem::current_path(data_directory / folder_); }
    explicit FileTest(const std::string& folder) : folder_(folder) {}

  private:
    std::string folder_;
};

std::string name_of(const testing::TestParamInfo<std::string>& info) {
    return info.param;
}

class ErrorsTest : public FileTest {
  protected:
    ErrorsTest() : FileTest("errors") {}
};

TEST_P(ErrorsTest, SaysWhatIsExpected) {
    const Compilation compilation{GetParam() + ".idl"};
    ASSERT_TRUE(compilation.preprocessed.ok) << compilation.preprocessed.message;
    EXPECT_TRUE(compilation.diagnostics.failed());
    const std::string messages = format(compilation.diagnostics, compilation.source);
    EXPECT_EQ(messages, expected(GetParam() + ".expected", messages));
}

INSTANTIATE_TEST_SUITE_P(Idl, ErrorsTest, testing::ValuesIn(idl_files("errors")), name_of);

class AcceptedTest : public FileTest {
  protected:
    AcceptedTest() : FileTest("accepted") {}
};

TEST_P(AcceptedTest, IsReadAsExpected) {
    const Compilation compilation{GetParam() + ".idl"};
    ASSERT_TRUE(compilation.preprocessed.ok) << compilation.preprocessed.message;
    EXPECT_FALSE(compilation.diagnostics.failed());
    // There is such a file where warnings are expected.
    EXPECT_EQ(format(compilation.diagnostics, compilation.source),
              read_file(GetParam() + ".warnings"));
    Diagnostics diagnostics;
    const ast::File file =
        parse::parse_file(tokenize(compilation.source, diagnostics), diagnostics);
    const std::string dump = ast::dump(file);
    EXPECT_EQ(dump, expected(GetParam() + ".dump", dump));
}

INSTANTIATE_TEST_SUITE_P(Idl, AcceptedTest, testing::ValuesIn(idl_files("accepted")), name_of);

class GoldenTest : public FileTest {
  protected:
    GoldenTest() : FileTest("golden") {}
};

TEST_P(GoldenTest, GeneratesTheSameOctets) {
    const Compilation compilation{GetParam() + ".idl"};
    EXPECT_EQ(format(compilation.diagnostics, compilation.source), "");
    const emit::GeneratedCode code = emit::generate(compilation.model, GetParam());
    EXPECT_EQ(code.header, expected(GetParam() + ".hpp", code.header));
    EXPECT_EQ(code.source, expected(GetParam() + ".cpp", code.source));
}

INSTANTIATE_TEST_SUITE_P(Idl, GoldenTest, testing::ValuesIn(idl_files("golden")), name_of);

TEST(PreprocessTest, SaysWhyAFileCannotBeRead) {
    const Preprocessed missing = preprocess("no_such_file.idl", {});
    EXPECT_FALSE(missing.ok);
    EXPECT_NE(missing.message.find("no_such_file.idl"), std::string::npos) << missing.message;
}

TEST(PreprocessTest, HandsOnMacrosAndDirectories) {
    std::filesystem::current_path(data_directory);
    const Preprocessed result =
        preprocess("preprocess/main.idl", {{"preprocess/elsewhere"}, {"LIMIT=12"}});
    ASSERT_TRUE(result.ok) << result.message;
    const Source source{"preprocess/main.idl", result.text};
    Diagnostics diagnostics;
    const model::Model model = compile(source, diagnostics);
    EXPECT_EQ(format(diagnostics, source), "");
    EXPECT_EQ(model.includes, std::vector<std::string>{"found.idl"});
    ASSERT_EQ(model.definitions.size(), 3U);
    EXPECT_FALSE(model.definitions[0]->in_main_file);
    EXPECT_EQ(std::get<std::uint64_t>(std::get<model::Constant>(model.definitions[1]->body).value),
              12U);
    // A name of the machine that the preprocessor would know.
    EXPECT_EQ(model.definitions[2]->name, "linux");
}

}  // namespace
}  // namespace canorb::idlc::test
