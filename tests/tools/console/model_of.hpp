#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <stdexcept>
#include <string>

#include "idlc/compile.hpp"
#include "idlc/diagnostics.hpp"
#include "idlc/emit/json.hpp"
#include "idlc/source.hpp"
#include "tools/console/model.hpp"

namespace canorb::console::test {

/// What the IDL compiler writes for this IDL.
inline std::string json_of(const std::string& idl) {
    const idlc::Source source{"test.idl", idl};
    idlc::Diagnostics diagnostics;
    const idlc::model::Model model = idlc::compile(source, diagnostics);
    if (diagnostics.failed()) throw std::invalid_argument{idlc::format(diagnostics, source)};
    return idlc::emit::json(model);
}

inline std::unique_ptr<Model> model_of(const std::string& idl) {
    auto model = std::make_unique<Model>();
    const auto error = model->add(json_of(idl), "test.idl");
    EXPECT_EQ(error.value_or(""), "");
    return model;
}

}  // namespace canorb::console::test
