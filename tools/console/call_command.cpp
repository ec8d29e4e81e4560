// canorb call REF OPERATION ARGS...

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "orb/ccdr/decoder.hpp"
#include "orb/core/reference.hpp"
#include "tools/console/arguments.hpp"
#include "tools/console/commands.hpp"
#include "tools/console/session.hpp"
#include "tools/console/values.hpp"

namespace canorb::console {
namespace {

/// Why there is no call; a sentence for people.
struct CannotCall {
    std::string reason;
};

Json members_json(const NamedValues& values) {
    Json json = Json::object();
    for (const auto& [name, value] : values) json[name] = value;
    return json;
}

std::string list_of_interfaces(const Model& model) {
    std::string names;
    for (const auto& [name, interface] : model.interfaces()) {
        if (!interface.is_local) names += (names.empty() ? "" : ", ") + name;
    }
    return names.empty() ? "none" : names;
}

std::string list_of_operations(const Interface& interface) {
    std::string text;
    for (const Operation& each : interface.operations) text += "\n  " + each.signature();
    return text.empty() ? " none" : text;
}

/// One call, from what people write to what they read.
class Call {
  public:
    Call(const CommonOptions& common, const CallOptions& options, const Model& model,
         const core::Reference& target)
        : common_(common), options_(options), model_(model), target_(target) {}

    /// All that can be said without asking the object, so that a mistake needs no bus.
    void prepare() {
        if (asks_the_orb()) return check_own_operation();
        const std::string& id = options_.interface.empty() ? target_.type_id : options_.interface;
        if (!id.empty()) return choose(id);
        if (target_.kind == core::Reference::Kind::group) {
            throw CannotCall{
                "this reference to a group does not say which interface its members have: say it "
                "with --interface. Known are: " +
                list_of_interfaces(model_)};
        }
    }

    int perform(Session& session) {
        const ObjectRef object = session.object(options_.reference);
        try {
            if (asks_the_orb()) return ask_the_orb(object);
            if (operation_ == nullptr) choose(object._interface_id());
            const InterfaceInfo declares{operation_->declared_in_id};
            const OperationInfo info{&declares, operation_->id, operation_->name,
                                     operation_->oneway, operation_->groupable};
            const InvokeResult result = object.invoke(info, parameters_);
            if (!result.exception_id.empty()) return show_user_exception(result);
            // Nobody answers these.
            if (target_.kind == core::Reference::Kind::group || operation_->oneway) {
                if (!session.send_all()) {
                    throw TIMEOUT(
                        "the message was not sent: nobody on the bus acknowledges it, or more "
                        "urgent ones keep it waiting",
                        Completion::maybe);
                }
                if (common_.json) print(Json{{"results", Json::object()}}.dump());
                return success;
            }
            return show_results(result.body);
        } catch (const SystemException& exception) {
            if (common_.json && !session.is_closed()) show_json(exception);
            throw;
        }
    }

  private:
    /// Those that every object has, whatever its interface.
    bool asks_the_orb() const {
        const std::string& name = options_.operation;
        return name == "_interface" || name == "_is_a" || name == "_non_existent";
    }

    void check_own_operation() const {
        const std::size_t wanted = options_.operation == "_is_a" ? 1 : 0;
        if (options_.arguments.size() == wanted) return;
        throw CannotCall{options_.operation + " takes " +
                         (wanted == 0 ? "no argument" : "one argument, a repository id")};
    }

    int ask_the_orb(const ObjectRef& object) const {
        Json answer;
        if (options_.operation == "_interface") {
            answer = object._interface_id();
        } else if (options_.operation == "_is_a") {
            answer = object._is_a(options_.arguments.at(0));
        } else {
            answer = object._non_existent();
        }
        show({{"result", std::move(answer)}});
        return success;
    }

    void choose(const std::string& name_or_id) {
        const Interface* const interface = model_.find_interface(name_or_id);
        if (interface == nullptr || !interface->defined) {
            throw CannotCall{"the interface " + name_or_id +
                             " is not in the IDL given (--idl, --idl-json). Known are: " +
                             list_of_interfaces(model_)};
        }
        if (interface->is_local)
            throw CannotCall{interface->name + " is a local interface: it is never on the bus"};
        operation_ = interface->find(options_.operation, options_.arguments.size());
        if (operation_ == nullptr) {
            throw CannotCall{interface->name + " has no operation or attribute '" +
                             options_.operation + "'. It has:" + list_of_operations(*interface)};
        }
        if (target_.kind == core::Reference::Kind::group && !operation_->groupable) {
            throw CannotCall{operation_->signature() +
                             " cannot be sent to a group: it has a result, an out or inout "
                             "parameter or a raises clause"};
        }
        auto encoded = encode_arguments(*operation_, options_.arguments, model_);
        if (!encoded) throw CannotCall{encoded.error()};
        parameters_ = std::move(*encoded);
    }

    int show_results(Bytes body) const {
        const auto results = decode_results(*operation_, body, model_);
        if (!results) {
            throw MARSHAL("the answer of " + operation_->name + ": " + results.error(),
                          Completion::yes);
        }
        show(*results);
        return success;
    }

    /// A result alone as it is; several values each with its name.
    void show(const NamedValues& values) const {
        if (common_.json) return print(to_text(Json{{"results", members_json(values)}}));
        const bool alone = values.size() == 1 && values.front().first == "result";
        for (const auto& [name, value] : values) {
            print((alone ? "" : name + " = ") + to_text(value));
        }
    }

    int show_user_exception(const InvokeResult& result) const {
        const Definition* const exception = model_.find_exception(result.exception_id);
        std::string text = (exception == nullptr ? "an exception that the IDL given does not have, "
                                                 : exception->name + ' ') +
                           '(' + to_text(Json(result.exception_id)) + ')';
        Json json{{"kind", "user"}, {"id", result.exception_id}};
        const auto members = exception == nullptr
                                 ? Result<NamedValues, std::string>{Failure{std::string{}}}
                                 : decode_members(*exception, result.body, model_);
        if (members) {
            if (!members->empty()) text += ": " + to_text(*members);
            json["name"] = exception->name;
            json["members"] = members_json(*members);
        } else {
            if (!members.error().empty()) text += ": " + members.error();
            if (!result.body.empty()) text += "; its members as octets: " + hex(result.body);
            json["octets"] = hex(result.body);
        }
        if (common_.json) print(to_text(Json{{"exception", std::move(json)}}));
        return fail(operation_->name + " raised " + text, call_failed);
    }

    static void show_json(const SystemException& exception) {
        print(to_text(Json{{"exception",
                            {{"kind", "system"},
                             {"id", exception._repository_id()},
                             {"name", name(exception.error().kind)},
                             {"completed", name(exception.completed())},
                             {"minor", exception.minor()},
                             {"explanation", describe(exception)}}}}));
    }

    const CommonOptions& common_;
    const CallOptions& options_;
    const Model& model_;
    const core::Reference& target_;
    const Operation* operation_ = nullptr;
    std::vector<std::uint8_t> parameters_;
};

}  // namespace

int call(const CommonOptions& common, const CallOptions& options) {
    const auto target = core::parse_reference(options.reference);
    if (!target) {
        return fail(
            "'" + options.reference + "' is no reference: " + std::string{target.error().why},
            usage_error);
    }
    if (target->kind == core::Reference::Kind::nil)
        return fail("this reference is nil: it refers to nothing", usage_error);
    const auto model = load(options.idl);
    if (!model) return fail(model.error(), usage_error);
    Call one{common, options, **model, *target};
    try {
        one.prepare();
    } catch (const CannotCall& error) {
        return fail(error.reason, usage_error);
    }
    return Session::run(common, [&](Session& session) {
        try {
            return one.perform(session);
        } catch (const CannotCall& error) {
            return fail(error.reason, usage_error);
        }
    });
}

}  // namespace canorb::console
