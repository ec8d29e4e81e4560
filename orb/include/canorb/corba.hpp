#pragma once

/// What <orb.idl> declares in CORBA's own module: the sequences of basic types, and the names that
/// strings have there. Generated code includes it where its IDL includes <orb.idl>.

#include <string>
#include <vector>

#include "canorb/object_ref.hpp"
#include "canorb/types.hpp"

namespace CORBA {

using Identifier = std::string;
using RepositoryId = std::string;
using ScopedName = std::string;
using VersionSpec = std::string;

using AnySeq = std::vector<canorb::Any>;
using BooleanSeq = std::vector<bool>;
using CharSeq = std::vector<char>;
using WCharSeq = std::vector<char16_t>;
using OctetSeq = std::vector<std::uint8_t>;
using ShortSeq = std::vector<std::int16_t>;
using UShortSeq = std::vector<std::uint16_t>;
using LongSeq = std::vector<std::int32_t>;
using ULongSeq = std::vector<std::uint32_t>;
using LongLongSeq = std::vector<std::int64_t>;
using ULongLongSeq = std::vector<std::uint64_t>;
using FloatSeq = std::vector<float>;
using DoubleSeq = std::vector<double>;
using LongDoubleSeq = std::vector<long double>;
using StringSeq = std::vector<std::string>;
using WStringSeq = std::vector<std::u16string>;

}  // namespace CORBA
