#include "orb/base/system_error.hpp"

#include <gtest/gtest.h>

#include <set>

namespace canorb {
namespace {

constexpr unsigned last_kind = static_cast<unsigned>(SystemErrorKind::transient);

TEST(SystemError, EveryKindIsFoundByItsRepositoryId) {
    std::set<std::string_view> ids;
    for (unsigned i = 0; i <= last_kind; ++i) {
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

TEST(SystemError, AnotherIdIsNoKind) {
    for (const char* id : {"", "TIMEOUT", "IDL:omg.org/CORBA/TIMEOUT:1.1",
                           "IDL:omg.org/CORBA/DATA_CONVERSION:1.0", "IDL:Devices/TIMEOUT:1.0"}) {
        EXPECT_FALSE(system_error_kind(id)) << id;
    }
}

}  // namespace
}  // namespace canorb
