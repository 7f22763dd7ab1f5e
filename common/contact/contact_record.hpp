#pragma once

#include "common/base/ledger.hpp"

/// The states of contact pairs; what a contact's owner reports is ContactRecord.
namespace ricochet::solver {

enum class ContactState { open, stick, slip };

/// Contact forces with a larger residual are counted as not converged, and the user is warned.
constexpr double converged_contact_residual = 1e-6;

}  // namespace ricochet::solver
