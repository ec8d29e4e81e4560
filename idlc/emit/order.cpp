#include "idlc/emit/order.hpp"

#include <algorithm>
#include <set>

namespace canorb::idlc::emit {

namespace {

using Set = std::set<const model::Definition*>;

bool is_ready(const model::Definition& definition, const Set& missing);

/// Whether what a value of the type contains is there. A sequence is content with a declaration,
/// and so is what points to a local interface.
bool is_ready(const model::Type& type, const Set& missing) {
    const model::Type& known = model::resolved(type);
    if (known.kind == model::TypeKind::array) return is_ready(*known.element, missing);
    if (known.kind != model::TypeKind::named) return true;
    const auto* interface = std::get_if<model::Interface>(&known.definition->body);
    if (interface != nullptr && interface->kind == model::InterfaceKind::local) return true;
    return missing.count(known.definition) == 0;
}

bool is_ready(const std::vector<model::Member>& members, const Set& missing) {
    return std::all_of(members.begin(), members.end(),
                       [&](const model::Member& member) { return is_ready(member.type, missing); });
}

/// Types that are declared in place are defined there; nothing refers to them from elsewhere yet.
bool are_ready(const model::Definitions& nested, const Set& missing) {
    return std::all_of(nested.begin(), nested.end(), [&](const model::Definition* definition) {
        return is_ready(*definition, missing);
    });
}

bool is_ready(const model::Definition& definition, const Set& missing) {
    if (const auto* body = std::get_if<model::Struct>(&definition.body)) {
        return are_ready(body->definitions, missing) && is_ready(body->members, missing) &&
               missing.count(body->base) == 0;
    }
    if (const auto* body = std::get_if<model::Exception>(&definition.body)) {
        return are_ready(body->definitions, missing) && is_ready(body->members, missing);
    }
    if (const auto* body = std::get_if<model::Union>(&definition.body)) {
        return are_ready(body->definitions, missing) &&
               std::all_of(body->cases.begin(), body->cases.end(),
                           [&](const auto& one) { return is_ready(one.member.type, missing); });
    }
    return true;
}

class Order {
  public:
    std::vector<Step> run(const model::Definitions& definitions) {
        mark_missing(definitions);
        walk(definitions);
        for (const Step& step : waiting_) steps_.push_back(step);
        return std::move(steps_);
    }

  private:
    void mark_missing(const model::Definitions& definitions) {
        for (const model::Definition* definition : definitions) {
            if (const auto* module = std::get_if<model::Module>(&definition->body)) {
                mark_missing(module->definitions);
            } else if (definition->in_main_file) {
                missing_.insert(definition);
            }
            if (const auto* interface = std::get_if<model::Interface>(&definition->body)) {
                if (definition->in_main_file) mark_missing(interface->definitions);
            }
        }
    }

    void walk(const model::Definitions& definitions) {
        for (const model::Definition* definition : definitions) {
            if (const auto* module = std::get_if<model::Module>(&definition->body)) {
                walk(module->definitions);
            } else if (definition->in_main_file) {
                place(definition);
            }
        }
    }

    void place(const model::Definition* definition) {
        if (!is_ready(*definition, missing_)) {
            steps_.push_back({definition, Step::Kind::declare});
            waiting_.push_back({definition, Step::Kind::define});
            return;
        }
        std::vector<Step> types;
        if (const auto* interface = std::get_if<model::Interface>(&definition->body)) {
            types = within(interface->definitions);
        }
        define({definition, Step::Kind::define});
        for (const Step& step : types) {
            if (step.kind == Step::Kind::inside) {
                steps_.push_back(step);
            } else {
                waiting_.push_back(step);
            }
        }
        release();
    }

    /// Which of an interface's types can be defined before its class is complete.
    std::vector<Step> within(const model::Definitions& definitions) {
        std::vector<Step> types;
        for (const model::Definition* definition : definitions) {
            const bool ready = is_ready(*definition, missing_);
            types.push_back({definition, ready ? Step::Kind::inside : Step::Kind::behind});
            if (ready) missing_.erase(definition);
        }
        return types;
    }

    void define(const Step& step) {
        steps_.push_back(step);
        missing_.erase(step.definition);
    }

    /// One that comes may be what the next waits for: they wait in their order.
    void release() {
        for (auto next = waiting_.begin(); next != waiting_.end();) {
            if (is_ready(*next->definition, missing_)) {
                define(*next);
                waiting_.erase(next);
                next = waiting_.begin();
            } else {
                ++next;
            }
        }
    }

    Set missing_;
    std::vector<Step> waiting_;
    std::vector<Step> steps_;
};

}  // namespace

std::vector<Step> cpp_order(const model::Definitions& definitions) {
    return Order{}.run(definitions);
}

}  // namespace canorb::idlc::emit
