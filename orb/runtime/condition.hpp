#pragma once

namespace canorb::runtime {

/// What a thread waits for: a function without parameters that tells whether it has come about. The
/// function is not copied, so that waiting does not allocate: it must outlive the Condition.
class Condition {
  public:
    template <typename Function>
    Condition(const Function& function)  // NOLINT(google-explicit-constructor): lambdas are given
        : function_(&function),
          ask_([](const void* f) -> bool { return (*static_cast<const Function*>(f))(); }) {}

    bool operator()() const { return ask_(function_); }

  private:
    const void* function_;
    bool (*ask_)(const void*);
};

}  // namespace canorb::runtime
