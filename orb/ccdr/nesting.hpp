#pragma once

namespace canorb::ccdr {

/// One level of values within values while it lives: codecs of recursive types make one, that of
/// any does. Below the 64th level it fails the Encoder or Decoder, so no message and no value
/// overflows the stack.
///
///     void decode(ccdr::Decoder& in, Tree& value) {
///         const ccdr::Nesting nesting{in};
///         if (!nesting) return;
template <typename Coder>
class Nesting {
  public:
    explicit Nesting(Coder& coder) : coder_(coder), entered_(coder.enter()) {}
    ~Nesting() { coder_.leave(); }
    Nesting(const Nesting&) = delete;
    Nesting& operator=(const Nesting&) = delete;

    explicit operator bool() const { return entered_; }

  private:
    Coder& coder_;
    bool entered_;
};

}  // namespace canorb::ccdr
