// What a forger can do who holds no key of the rig: take entries away, write files with a key of their own.
#include <gtest/gtest.h>

#include <filesystem>

#include "daemon/record/anchor.hpp"
#include "daemon/record/signature.hpp"
#include "tests/record/audited.hpp"

namespace dwell::record {
namespace {

AuditOptions by_all(const Scratch& scratch) {
  AuditOptions options = with_ledger(scratch);
  options.keys = {sample_key().public_key()};
  return options;
}

TEST(Forger, ARunWhoseEntriesAreAllGoneIsCutAndTheLedgerMissesIt) {
  const Scratch scratch(true);
  const Ledger ledger = recorded(scratch, 2);
  const std::string path = scratch.path("a.dwell");
  ASSERT_TRUE(forge(path, "DELETE FROM entry; DELETE FROM note"));
  const Audit known = audited(path, with_ledger(scratch));
  EXPECT_EQ(known.state, AuditState::tampered);
  EXPECT_TRUE(says(known.where, "cut after entry 0; the ledger knows entry ")) << known.where;
  const Audit asked = audited(path, pinned(sample_key()));
  EXPECT_EQ(asked.state, AuditState::tampered);
  EXPECT_TRUE(says(asked.where, "it has no entry")) << asked.where;
  const auto all = audit_ledger(with_ledger(scratch).ledger, scratch.path(), {});
  ASSERT_EQ(all->missing.size(), 1u);
  EXPECT_TRUE(says(all->missing[0], "run 1") && says(all->missing[0], "holds no entry")) << all->missing[0];
  std::filesystem::rename(path, scratch.path("other.dwell"));
  EXPECT_EQ(audited(scratch.path("other.dwell"), with_ledger(scratch)).state, AuditState::open);
  EXPECT_EQ(audit_ledger(with_ledger(scratch).ledger, scratch.path(), {})->missing.size(), 1u) << "it shows there";
}

TEST(Forger, ARunOfWhichOnlyAnAnchorKnowsAnEntryCannotBeEmptied) {
  const Scratch scratch(true);
  Ledger ledger = recorded(scratch, 1);
  RunHeader header = sample_header(2, sample_key());
  header.previous_head = ledger.newest_head();
  ASSERT_TRUE(ledger.run_begins(header, "b.dwell"));
  write_sample(scratch.path("b.dwell"), {.seed = 2, .end = SampleEnd::log_left, .header = header});
  std::filesystem::remove(scratch.path("b.dwell-wal"));
  AuditOptions options = with_ledger(scratch);
  EXPECT_EQ(audited(scratch.path("b.dwell"), options).state, AuditState::open) << "a crash leaves the same";
  Anchor anchor = ledger.head();
  anchor.origin = "dwell/run/" + header.id;
  anchor.utc = "2026-11-24T05:00:00.000000Z";
  options.anchors = {scratch.write("anchors", to_line(anchor))};
  const Audit audit = audited(scratch.path("b.dwell"), options);
  EXPECT_TRUE(says(audit.where, "cut after entry 0; the anchor of 2026-11-24")) << audit.where;
}

// Whoever may write the directory can write all of it anew with a key of their own, the ledger included.
TEST(Forger, ALedgerAloneMakesNoKeyTrusted) {
  const Scratch scratch(true);
  const Ledger ledger = recorded(scratch, 1);
  const std::string path = scratch.path("a.dwell");
  const Audit alone = audited(path, with_ledger(scratch));
  EXPECT_EQ(alone.state, AuditState::intact) << alone.where;
  EXPECT_FALSE(alone.trusted);
  EXPECT_EQ(key_verdict(alone), "key " + alone.key + " not trusted (known to this ledger)");
  const Audit pinned = audited(path, by_all(scratch));
  EXPECT_TRUE(pinned.trusted);
  EXPECT_EQ(key_verdict(pinned), "key " + pinned.key + " trusted");
  const std::string file = with_ledger(scratch).ledger;
  EXPECT_FALSE(audit_ledger(file, scratch.path(), {})->trusted);
  EXPECT_EQ(audit_ledger(file, scratch.path(), {})->key, alone.key);
  EXPECT_TRUE(audit_ledger(file, scratch.path(), by_all(scratch))->trusted);
  AuditOptions another = with_ledger(scratch);
  another.keys = {sample_other().public_key()};
  EXPECT_EQ(audited(path, another).state, AuditState::tampered);
  another.keys.push_back(sample_key().public_key());
  EXPECT_TRUE(audited(path, another).trusted) << "one of several";
}

TEST(Forger, AFileInARunsPlaceThatIsNoRunIsMissed) {
  const Scratch scratch(true);
  const Ledger ledger = recorded(scratch, 2);
  scratch.write("a.dwell", "");
  const auto all = audit_ledger(with_ledger(scratch).ledger, scratch.path(), {});
  ASSERT_EQ(all->missing.size(), 1u);
  EXPECT_TRUE(says(all->missing[0], "cannot be read")) << all->missing[0];
}

// Anybody knows the public half of the rig's key, and can announce it as the next one.
TEST(Forger, ALedgerThatOnlyAnnouncesTheKeyIsNotSignedByIt) {
  const Scratch scratch(true);
  {
    Ledger forged = *Ledger::open(scratch.path(), sample_other());
    RunHeader header = sample_header(1, sample_other());
    ASSERT_TRUE(forged.run_begins(header, "a.dwell"));
    const std::string head = write_sample(scratch.path("a.dwell"), {.seed = 1, .header = header}, sample_other());
    const auto seq = static_cast<std::int64_t>(rows_of(scratch.path("a.dwell")).size());
    ASSERT_TRUE(forged.run_ends({1, head, seq, "closed"}));
    ASSERT_TRUE(forged.key_changes(sample_key().public_key()));
  }
  const Audit audit = audited(scratch.path("a.dwell"), by_all(scratch));
  EXPECT_EQ(audit.state, AuditState::tampered);
  EXPECT_FALSE(audit.trusted);
  EXPECT_TRUE(says(audit.where, "not by the key asked for")) << audit.where;
  const auto ledger = audit_ledger(with_ledger(scratch).ledger, scratch.path(), by_all(scratch));
  EXPECT_FALSE(ledger->unbroken);
  EXPECT_TRUE(says(ledger->where, sample_other().public_key().fingerprint())) << ledger->where;
}

// The service vouches for a user, a person's own key for nobody: an entry with both would be shown as either.
TEST(Forger, ASignatureByAnOwnKeyCannotNameAUserOfTheRig) {
  const auto both = parse_personal_signature(
      R"({"name":"Anna","meaning":"approved","reason":"","utc":"2026-11-24T08:00:00.000000Z","seq":3,"head":")" +
      std::string(64, '0') + R"(","person":{"uid":0,"name":"root"},"vkey":"x+1+A","note":"n"})");
  ASSERT_FALSE(both);
  EXPECT_TRUE(says(both.error(), "both a \"person\" of the service and a \"vkey\" of their own")) << both.error();
}

// No note of the service covers such an entry, and the person's note not all of it.
TEST(Forger, TheEntryOfASignatureByAnOwnKeyCannotBeAltered) {
  for (const char* alteration : {"SET t_ns = t_ns + 1",
                                 "SET body = CAST(replace(CAST(body AS TEXT), '{\"name\"', "
                                 "'{\"more\":\"approved\",\"name\"') AS BLOB)",
                                 "SET body = CAST(CAST(body AS TEXT) || ' ' AS BLOB)"}) {
    const Scratch scratch(true);
    Ledger ledger = recorded(scratch, 1);
    const std::string path = scratch.path("a.dwell");
    const auto made = sign_by_own_key(path, sample_words(), sample_other());
    ASSERT_TRUE(made && ledger.run_signed(1, *made));
    EXPECT_EQ(audited(path, by_all(scratch)).state, AuditState::intact);
    ASSERT_TRUE(forge(path, std::string("UPDATE entry ") + alteration + " WHERE kind = 'signature'"));
    forge_heads(path);
    const Audit audit = audited(path, by_all(scratch));
    EXPECT_EQ(audit.state, AuditState::tampered) << alteration;
    EXPECT_TRUE(says(audit.where, "entry " + std::to_string(made->seq + 1))) << audit.where;
  }
}

// Whoever signs with a key of their own chooses the words.
TEST(Forger, NoWordsOfAPersonLookLikeTheServicesCountersignature) {
  const Scratch scratch(true);
  const std::string path = scratch.path("a.dwell");
  write_sample(path, {.seed = 6, .end = SampleEnd::signed_by_service});
  PersonalSignature words = sample_words();
  words.name = "countersigned by the service for user 0 (root): Anna";
  ASSERT_TRUE(sign_by_own_key(path, words, sample_other()));
  const Audit audit = audited(path);
  ASSERT_EQ(audit.signatures.size(), 2u);
  EXPECT_EQ(audit.signatures[0].text.rfind("countersigned by the service for user 1000 (anna): Anna Huber: ", 0), 0u)
      << audit.signatures[0].text;
  EXPECT_EQ(audit.signatures[1].text.rfind("with the key ", 0), 0u) << audit.signatures[1].text;
}

}  // namespace
}  // namespace dwell::record
