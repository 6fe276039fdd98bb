#include "daemon/record/audit.hpp"
#include "daemon/record/ledger.hpp"
#include "daemon/record/signature.hpp"
namespace dwell::record {
Result<PersonalSignature> sign_by_service(const std::string&, PersonalSignature, const SigningKey&) { return tl::unexpected(std::string("stub")); }
Result<PersonalSignature> sign_by_own_key(const std::string&, PersonalSignature, const SigningKey&) { return tl::unexpected(std::string("stub")); }
Result<Audit> audit_run(const std::string&, const AuditOptions&) { return tl::unexpected(std::string("stub")); }
Result<LedgerAudit> audit_ledger(const std::string&, const std::string&, const AuditOptions&) { return tl::unexpected(std::string("stub")); }
struct Ledger::Impl {};
Result<Ledger> Ledger::open(const std::string&, const SigningKey&) { return tl::unexpected(std::string("stub")); }
Ledger::Ledger(Ledger&&) noexcept = default;
Ledger& Ledger::operator=(Ledger&&) noexcept = default;
Ledger::~Ledger() = default;
std::int64_t Ledger::next_run() const noexcept { return 0; }
Result<void> Ledger::run_begins(const RunHeader&, const std::string&) { return {}; }
}
