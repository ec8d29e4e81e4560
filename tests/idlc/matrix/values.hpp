#pragma once

#include <memory>
#include <sstream>
#include <string>

#include "random.hpp"
#include "subject.hpp"

namespace canorb::test {

/// A value that can be a random one, for the types of types.idl.
class Value {
  public:
    virtual ~Value() = default;
    virtual Subject& subject() = 0;
    virtual void randomize(Random& random) = 0;
    virtual std::string printed() const = 0;
    virtual Any to_any() const = 0;
    virtual bool is_in(const Any& any) const = 0;
};

template <typename T>
class ValueOf final : public Value {
  public:
    static std::unique_ptr<Value> make() { return std::make_unique<ValueOf>(); }

    Subject& subject() override { return subject_; }
    void randomize(Random& random) override { subject_.value = random_value<T>(random); }
    std::string printed() const override {
        std::ostringstream out;
        print(out, subject_.value);
        return out.str();
    }
    Any to_any() const override {
        Any any;
        any <<= subject_.value;
        return any;
    }
    bool is_in(const Any& any) const override {
        T value{};
        return (any >>= value) && value == subject_.value;
    }

  private:
    SubjectOf<T> subject_;
};

using MakeValue = std::unique_ptr<Value> (*)();

/// The types of types.idl by name. Each of the files that CMakeLists.txt makes has some of them.
const std::map<std::string_view, MakeValue>& all_values();
void add_values_1(std::map<std::string_view, MakeValue>& to);
void add_values_2(std::map<std::string_view, MakeValue>& to);
void add_values_3(std::map<std::string_view, MakeValue>& to);
void add_values_4(std::map<std::string_view, MakeValue>& to);

}  // namespace canorb::test
