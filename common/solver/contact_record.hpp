#pragma once

#include "common/fem/ledger.hpp"

/// The states of contact pairs, and what a contact's owner reports of them.
namespace ricochet::solver {

enum class ContactState { open, stick, slip };

using fem::ContactRecord;

/// Contact forces with a larger residual are counted as not converged, and the user is warned.
constexpr double converged_contact_residual = 1e-6;

}  // namespace ricochet::solver
