#pragma once

#include <cstdint>
#include <vector>

#include "idlc/model.hpp"

namespace canorb::idlc::emit {

/// One definition in its turn.
struct Step {
    enum class Kind : std::uint8_t {
        declare,  ///< only its name: the definition comes in a later step
        define,
        inside,  ///< defined within the class of the interface around it, which came before
        behind,  ///< declared within that class, and defined here
    };

    const model::Definition* definition;
    Kind kind = Kind::define;
};

/// The order in which C++ can have the definitions of a file, without modules: that of the IDL,
/// but a struct, union or exception that contains a reference to an interface comes behind the
/// interface. Types of interfaces follow the interface.
std::vector<Step> cpp_order(const model::Definitions& definitions);

}  // namespace canorb::idlc::emit
