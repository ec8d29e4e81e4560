#pragma once

/// The object adapters of an ORB: which servant is behind which object (CORBA's PortableServer).
///
///     orb.root_poa().activate_object_with_id(1, motor);
///
///     // Pumps with ids that survive restarts, held until all of them are there:
///     canorb::Poa& pumps = orb.root_poa().create_POA(
///         "pumps", nullptr,
///         {.lifespan = canorb::LifespanPolicy::persistent,
///          .id_assignment = canorb::IdAssignmentPolicy::user_id});
///     for (int i = 0; i < 8; ++i) pumps.activate_object_with_id(10 + i, pump[i]);
///     pumps.the_POAManager().activate();

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "canorb/exceptions.hpp"
#include "canorb/object_ref.hpp"
#include "canorb/servant.hpp"
#include "orb/poa/object_adapter.hpp"
#include "orb/poa/policies.hpp"

namespace canorb {

/// A text that can be a template's argument.
template <std::size_t N>
struct ExceptionId {
    constexpr ExceptionId(const char (&id)[N]) { std::copy_n(id, N, text); }  // NOLINT: implicit
    char text[N]{};
};

/// A user exception of CORBA's PortableServer without members.
template <ExceptionId Id>
class PortableServerException final : public UserException {
  public:
    std::string_view _repository_id() const noexcept override { return Id.text; }
};

/// create_POA: the parent has a child of that name.
using AdapterAlreadyExists =
    PortableServerException<"IDL:omg.org/PortableServer/POA/AdapterAlreadyExists:1.0">;
/// find_POA: it has none.
using AdapterNonExistent =
    PortableServerException<"IDL:omg.org/PortableServer/POA/AdapterNonExistent:1.0">;
/// The object id is in use, in this POA or another one of the ORB.
using ObjectAlreadyActive =
    PortableServerException<"IDL:omg.org/PortableServer/POA/ObjectAlreadyActive:1.0">;
/// No object is active with this id in this POA.
using ObjectNotActive =
    PortableServerException<"IDL:omg.org/PortableServer/POA/ObjectNotActive:1.0">;
/// UNIQUE_ID: the servant is behind an object of this POA already.
using ServantAlreadyActive =
    PortableServerException<"IDL:omg.org/PortableServer/POA/ServantAlreadyActive:1.0">;
/// The servant is behind no object of this POA, and cannot be activated implicitly.
using ServantNotActive =
    PortableServerException<"IDL:omg.org/PortableServer/POA/ServantNotActive:1.0">;
/// The reference is not one of this POA.
using WrongAdapter = PortableServerException<"IDL:omg.org/PortableServer/POA/WrongAdapter:1.0">;
/// The POA's policies do not allow the operation.
using WrongPolicy = PortableServerException<"IDL:omg.org/PortableServer/POA/WrongPolicy:1.0">;
/// The POA manager is inactive, and remains so.
using AdapterInactive =
    PortableServerException<"IDL:omg.org/PortableServer/POAManager/AdapterInactive:1.0">;

/// create_POA: the policies do not go together; what() says why.
class InvalidPolicy final : public UserException {
  public:
    explicit InvalidPolicy(std::uint16_t which, const char* why) : index(which), why_(why) {}

    std::string_view _repository_id() const noexcept override {
        return "IDL:omg.org/PortableServer/POA/InvalidPolicy:1.0";
    }
    const char* what() const noexcept override { return why_; }

    /// The first member of PoaPolicies that is at fault, from 0.
    std::uint16_t index;

  private:
    const char* why_;
};

/// An object's id within its ORB.
using ObjectId = ObjectIndex;

class Poa;

/// What happens to requests for the objects of one or more POAs. All functions may be called from
/// any thread, and from servants unless they wait. All but get_state() throw AdapterInactive when
/// it is inactive. Where `wait_for_completion` is true they return when no servant call of these
/// POAs is running any more; from within a servant or callback of this ORB that would be for ever,
/// and is BAD_INV_ORDER with nothing changed.
class PoaManager {
  public:
    PoaManager(const PoaManager&) = delete;
    PoaManager& operator=(const PoaManager&) = delete;

    /// Requests are served, those that were held first, in their order.
    void activate();
    /// Requests wait: at most 64 of each manager, the others are answered TRANSIENT.
    void hold_requests(bool wait_for_completion);
    /// Requests, also those that were held, are answered TRANSIENT; group requests are dropped and
    /// counted.
    void discard_requests(bool wait_for_completion);
    /// Requests are answered OBJ_ADAPTER, for ever.
    void deactivate(bool wait_for_completion);
    PoaManagerState get_state() const;

  private:
    friend class Poa;
    friend class runtime::OrbImpl;
    PoaManager(runtime::OrbImpl& orb, poa::ManagerId id) : orb_(orb), id_(id) {}

    runtime::OrbImpl& orb_;
    poa::ManagerId id_;
};

/// An object adapter. It lives as long as its Orb; after destroy() all functions but the_name()
/// throw OBJECT_NOT_EXIST.
///
/// The servants remain the application's, and must stay alive until they are deactivated and the
/// calls that they were in have ended, or the Orb is gone. A servant may deactivate itself, leave
/// its groups and be destroyed inside its own call, as the last thing that the call does with it.
///
/// Object ids are shared by all POAs of an ORB: 1..1023 for the application, 1024..2047 for the
/// ORB. All functions may be called from any thread and from servants.
class Poa {
  public:
    Poa(const Poa&) = delete;
    Poa& operator=(const Poa&) = delete;

    /// A child. `manager` may be shared with other POAs; null: a new one, which is holding. Throws
    /// AdapterAlreadyExists, InvalidPolicy, AdapterInactive when the manager is.
    Poa& create_POA(std::string_view name, PoaManager* manager, const PoaPolicies& policies = {});
    /// The child of that name. Throws AdapterNonExistent.
    Poa& find_POA(std::string_view name);
    /// Deactivates its objects, which then leave their groups, and destroys it and all below it;
    /// its name is free again. With `wait_for_completion`, which is BAD_INV_ORDER in a servant or
    /// callback of this ORB, it returns when no call of its servants is running any more.
    void destroy(bool wait_for_completion);

    const std::string& the_name() const;
    /// Null for the root.
    Poa* the_parent() const;
    std::vector<Poa*> the_children() const;
    PoaManager& the_POAManager() const;
    PoaPolicies policies() const;

    /// Gives the servant the next id from 1024. Throws ServantAlreadyActive, NO_RESOURCES when all
    /// have been given out, WrongPolicy unless ids are the system's.
    ObjectRef activate_object(Servant& servant);
    /// Gives the servant this id: 1..1023 with USER_ID and in the root POA; with SYSTEM_ID one that
    /// this POA gave out and that is not in use. Throws ObjectAlreadyActive, ServantAlreadyActive,
    /// BAD_PARAM.
    ObjectRef activate_object_with_id(ObjectId id, Servant& servant);
    /// Takes the object out of service and out of its groups. Calls that are in its servant go on
    /// to their end; with `wait_for_completion`, which is BAD_INV_ORDER in a servant or callback of
    /// this ORB, it returns when they have, and the servant may be destroyed. Throws
    /// ObjectNotActive.
    void deactivate_object(ObjectId id, bool wait_for_completion = false);

    /// A reference to an object that is to be activated later, of the interface with this
    /// repository id, with the next id of the system's. Throws WrongPolicy, NO_RESOURCES.
    ObjectRef create_reference(std::string_view repository_id);
    /// The same with this id. Throws BAD_PARAM when activate_object_with_id() would.
    ObjectRef create_reference_with_id(ObjectId id, std::string_view repository_id);

    /// Where the servant is active, and ids are unique: its id. Otherwise it is activated, where
    /// ids are the system's (implicit activation). Throws ServantNotActive; WrongPolicy with
    /// USER_ID and MULTIPLE_ID; NO_RESOURCES.
    ObjectId servant_to_id(Servant& servant);
    /// The same as a reference.
    ObjectRef servant_to_reference(Servant& servant);
    /// The servant behind an object of this POA. Throws WrongAdapter, ObjectNotActive.
    Servant& reference_to_servant(const ObjectRef& reference) const;
    /// Throws WrongAdapter when it is no reference to an object that this POA has or had.
    ObjectId reference_to_id(const ObjectRef& reference) const;
    /// Throws ObjectNotActive.
    Servant& id_to_servant(ObjectId id) const;
    /// Throws ObjectNotActive.
    ObjectRef id_to_reference(ObjectId id) const;

  private:
    friend class runtime::OrbImpl;
    Poa(runtime::OrbImpl& orb, poa::PoaId id, PoaManager& manager)
        : orb_(orb), id_(id), manager_(manager) {}

    runtime::OrbImpl& orb_;
    poa::PoaId id_;
    PoaManager& manager_;
};

}  // namespace canorb
