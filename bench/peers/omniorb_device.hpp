// Bench::Device by omniORB: its servant, and an ORB with one.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include <operations.hh>

namespace peers {

class Device final : public POA_Bench::Device {
  public:
    CORBA::Float level() override { return 0.75F; }
    void level(CORBA::Float /*value*/) override {}
    void ping() override {}
    void SetAttributeValueUL(const char* /*attrName*/, CORBA::ULong /*idxVal*/,
                             CORBA::ULong /*attrValue*/) override {}
    CORBA::Float read() override { return 21.5F; }
    void push(CORBA::UShort /*id*/, CORBA::Float /*value*/) override {}
    Bench::State status() override { return Bench::running; }
    void rename(const char* /*name*/) override {}
    void load(const Bench::Block& /*data*/) override {}
    void limits(CORBA::Float& low, CORBA::Float& high) override;
    CORBA::Float convert(CORBA::UShort channel) override;
    void forbidden() override;
    void attach(Bench::Device_ptr /*peer*/) override {}
};

/// An ORB, ended with its object.
class OmniOrb {
  public:
    using Options = std::vector<std::pair<std::string, std::string>>;  // without -ORB

    explicit OmniOrb(const Options& options);
    ~OmniOrb();
    OmniOrb(const OmniOrb&) = delete;
    OmniOrb& operator=(const OmniOrb&) = delete;

    /// Serves a device from now on. Its object key is KEY and nothing else, which omniORB allows
    /// in its POA for interoperable naming services only: other keys name the POA, too.
    Bench::Device_var serve(const char* key);
    /// Asks nobody: the reference must say what it refers to.
    Bench::Device_var device(const std::string& reference);
    std::string to_string(Bench::Device_ptr device);

  private:
    CORBA::ORB_var orb_;
};

/// The shortest that allows for more than 256 objects.
inline constexpr const char* object_key = "d1";

/// Prints the reference, and serves until a signal ends it. The caller has blocked those.
void serve_until_signal(const OmniOrb::Options& options);

}  // namespace peers
