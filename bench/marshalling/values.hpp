#pragma once

#include <cstdint>
#include <string>
#include <vector>

/// What all three sides encode and decode: the arguments and results of bench/operations.idl.
struct Values {
    std::string attribute = "TemperatureSetPoint";
    std::uint32_t index = 7;
    std::uint32_t setting = 1500;
    float read = 21.5F;
    std::uint16_t id = 1025;
    float level = 0.75F;
    std::uint32_t status = 2;  ///< the enumerator `running`
    std::string name = "abcdefghabcdefghabcdefghabcdefghabcdefghabcdefghabcdefghabcdefgh";
    std::vector<std::uint8_t> block = [] {
        std::vector<std::uint8_t> octets;
        for (unsigned i = 0; i < 256; ++i) octets.push_back(static_cast<std::uint8_t>(i * 7));
        return octets;
    }();
    float low = 18.0F;
    float high = 24.0F;
    std::uint16_t channel = 9;
    std::string user_exception = "IDL:Bench/NoSuchChannel:1.0";
    std::string system_exception = "IDL:omg.org/CORBA/NO_PERMISSION:1.0";
    std::uint32_t minor = 0;
    std::uint32_t completion = 0;  ///< COMPLETED_YES
    /// A reference as text, for who has no references: the one that canorb encodes, stringified.
    std::string reference;
};
