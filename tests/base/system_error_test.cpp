#include "orb/base/system_error.hpp"

#include <gtest/gtest.h>

#include <iterator>
#include <set>
#include <string>

namespace canorb {
namespace {

TEST(SystemError, EveryKindIsFoundByItsRepositoryId) {
    std::set<std::string_view> ids;
    for (unsigned i = 0; i < system_error_kind_count; ++i) {
        const auto kind = static_cast<SystemErrorKind>(i);
        EXPECT_EQ(system_error_kind(repository_id(kind)), kind) << repository_id(kind);
        EXPECT_TRUE(ids.insert(repository_id(kind)).second) << repository_id(kind);
    }
}

TEST(SystemError, HasCorbasNames) {
    EXPECT_EQ(repository_id(SystemErrorKind::unknown), "IDL:omg.org/CORBA/UNKNOWN:1.0");
    EXPECT_EQ(repository_id(SystemErrorKind::imp_limit), "IDL:omg.org/CORBA/IMP_LIMIT:1.0");
    EXPECT_EQ(repository_id(SystemErrorKind::obj_adapter), "IDL:omg.org/CORBA/OBJ_ADAPTER:1.0");
    EXPECT_EQ(repository_id(SystemErrorKind::object_not_exist),
              "IDL:omg.org/CORBA/OBJECT_NOT_EXIST:1.0");
    EXPECT_EQ(repository_id(SystemErrorKind::transient), "IDL:omg.org/CORBA/TRANSIENT:1.0");
    EXPECT_EQ(name(SystemErrorKind::timeout), "TIMEOUT");
    EXPECT_EQ(name(SystemErrorKind::object_not_exist), "OBJECT_NOT_EXIST");
    EXPECT_EQ(name(Completion::yes), "YES");
    EXPECT_EQ(name(Completion::no), "NO");
    EXPECT_EQ(name(Completion::maybe), "MAYBE");
}

TEST(SystemError, HasAllOfCorba26) {
    // CORBA 2.6, 4.12.3 "Standard Exception Definitions", in its order.
    const char* names[] = {"UNKNOWN",
                           "BAD_PARAM",
                           "NO_MEMORY",
                           "IMP_LIMIT",
                           "COMM_FAILURE",
                           "INV_OBJREF",
                           "NO_PERMISSION",
                           "INTERNAL",
                           "MARSHAL",
                           "INITIALIZE",
                           "NO_IMPLEMENT",
                           "BAD_TYPECODE",
                           "BAD_OPERATION",
                           "NO_RESOURCES",
                           "NO_RESPONSE",
                           "PERSIST_STORE",
                           "BAD_INV_ORDER",
                           "TRANSIENT",
                           "FREE_MEM",
                           "INV_IDENT",
                           "INV_FLAG",
                           "INTF_REPOS",
                           "BAD_CONTEXT",
                           "OBJ_ADAPTER",
                           "DATA_CONVERSION",
                           "OBJECT_NOT_EXIST",
                           "TRANSACTION_REQUIRED",
                           "TRANSACTION_ROLLEDBACK",
                           "INVALID_TRANSACTION",
                           "INV_POLICY",
                           "CODESET_INCOMPATIBLE",
                           "REBIND",
                           "TIMEOUT",
                           "TRANSACTION_UNAVAILABLE",
                           "TRANSACTION_MODE",
                           "BAD_QOS"};
    for (const std::string text : names) {
        const auto kind = system_error_kind("IDL:omg.org/CORBA/" + text + ":1.0");
        ASSERT_TRUE(kind) << text;
        EXPECT_EQ(name(*kind), text);
    }
    EXPECT_EQ(std::size(names), system_error_kind_count);
}

TEST(SystemError, AnotherIdIsNoKind) {
    for (const char* id : {"", "TIMEOUT", "IDL:omg.org/CORBA/TIMEOUT:1.1",
                           "IDL:omg.org/CORBA/DATA_CONVERSIONS:1.0", "IDL:Devices/TIMEOUT:1.0"}) {
        EXPECT_FALSE(system_error_kind(id)) << id;
    }
}

}  // namespace
}  // namespace canorb
