#include "daemon/record/audit.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "daemon/record/anchor.hpp"
#include "daemon/record/ledger.hpp"
#include "daemon/record/ledger_check.hpp"
#include "daemon/record/signature.hpp"
#include "tests/record/audited.hpp"

namespace dwell::record {
namespace {

TEST(Audit, AClosedRunIsIntactAndUntrustedWithoutAKey) {
  const Scratch scratch(true);
  const std::string path = scratch.path("a.dwell");
  const SampleFile run{.seed = 6, .blocks = 4};
  const std::string head = write_sample(path, run);
  const Audit audit = audited(path);
  EXPECT_EQ(audit.state, AuditState::intact) << audit.where;
  EXPECT_EQ(audit.head, head);
  EXPECT_EQ(audit.run, 7);
  EXPECT_EQ(audit.samples, sample_count(run));
  EXPECT_EQ(audit.key, sample_key().public_key().fingerprint());
  EXPECT_FALSE(audit.trusted);
  EXPECT_FALSE(audit.until_s.has_value());
  EXPECT_TRUE(audited(path, pinned(sample_key())).trusted);
}

TEST(Audit, AnOpenRunSaysUpToWhenItIsValid) {
  const Scratch scratch(true);
  const std::string path = scratch.path("a.dwell");
  write_sample(path, {.seed = 6, .end = SampleEnd::log_left, .blocks = 4, .records = 500});
  const Audit audit = audited(path);
  EXPECT_EQ(audit.state, AuditState::open) << audit.where;
  EXPECT_DOUBLE_EQ(audit.until_s.value_or(0.0), 2.0);  // 4 blocks of 500 records, 1 ms each
  EXPECT_EQ(audit.until_utc, "2026-11-23T03:12:19.250000Z");
}

TEST(Audit, ARunWrittenAnewWithAnotherKeyIsFoundByAPinnedKeyAndByTheLedger) {
  const Scratch scratch(true);
  const std::string path = scratch.path("a.dwell");
  const Ledger ledger = recorded(scratch, 1);
  std::filesystem::remove(path);
  RunHeader header = sample_header(1, sample_other());
  write_sample(path, {.seed = 1, .header = header}, sample_other());
  EXPECT_EQ(audited(path).state, AuditState::intact) << "nothing but the key tells";
  EXPECT_FALSE(audited(path).trusted);
  const Audit with_key = audited(path, pinned(sample_key()));
  EXPECT_EQ(with_key.state, AuditState::tampered);
  EXPECT_TRUE(says(with_key.where, "not by the key asked for")) << with_key.where;
  EXPECT_TRUE(says(with_key.where, sample_other().public_key().fingerprint())) << with_key.where;
  EXPECT_EQ(audited(path, with_ledger(scratch)).state, AuditState::tampered);
}

TEST(Audit, AnAlteredEntryIsNamed) {
  const Scratch scratch(true);
  const std::string path = scratch.path("a.dwell");
  write_sample(path, {.seed = 6});
  ASSERT_TRUE(forge(path, "UPDATE entry SET t_ns = t_ns + 1 WHERE seq = 4"));
  EXPECT_TRUE(says(audited(path).where, "entry 4: was altered")) << audited(path).where;
  forge_heads(path);
  EXPECT_TRUE(says(audited(path).where, "the note on entry ")) << audited(path).where;
  ASSERT_TRUE(forge(path, "DELETE FROM note"));
  EXPECT_TRUE(says(audited(path).where, "the end is not signed")) << audited(path).where;
}

TEST(Audit, ANoteThatIsGoneIsMissedThoughALaterOneCoversItsEntries) {
  const Scratch scratch(true);
  const std::string path = scratch.path("a.dwell");
  write_sample(path, {.seed = 6});
  ASSERT_TRUE(forge(path, "DELETE FROM note WHERE seq = (SELECT min(seq) FROM note)"));
  EXPECT_TRUE(says(audited(path).where, "it follows an earlier note, and there is none")) << audited(path).where;
}

// The newest signature is the only one that an audit verifies; the hash in each note covers the others.
TEST(Audit, AnAlteredSignatureUnderAnEarlierNoteIsFoundThoughOnlyTheNewestIsVerified) {
  const Scratch scratch(true);
  const std::string path = scratch.path("a.dwell");
  write_sample(path, {.seed = 6, .blocks = 5});
  const Files files = files_in(scratch);
  for (const int from_end : {10, 50, 80}) {
    put_files(scratch, files);
    const std::string at = "(length(text) - " + std::to_string(from_end) + ")";
    // Another letter of base64, so that only the signature's own bytes differ.
    ASSERT_TRUE(forge(path, "UPDATE note SET text = substr(text, 1, " + at + ") || CASE substr(text, 1 + " + at +
                                ", 1) WHEN 'x' THEN 'y' ELSE 'x' END || substr(text, 2 + " + at +
                                ") WHERE seq = (SELECT min(seq) FROM note)"));
    ASSERT_NE(files_in(scratch), files);
    for (const bool every : {false, true}) {
      const Audit audit =
          audited(path, {.keys = {}, .ledger = {}, .anchors = {}, .progress = {}, .every_signature = every});
      EXPECT_EQ(audit.state, AuditState::tampered);
      EXPECT_TRUE(says(audit.where, "the note on entry 4: the signature does not hold")) << audit.where;
    }
  }
}

TEST(Audit, EverySignatureCanBeVerifiedByItself) {
  const Scratch scratch(true);
  const std::string path = scratch.path("a.dwell");
  write_sample(path, {.seed = 6, .end = SampleEnd::signed_by_both});
  const Audit audit = audited(path, {.keys = {}, .ledger = {}, .anchors = {}, .progress = {}, .every_signature = true});
  EXPECT_EQ(audit.state, AuditState::intact) << audit.where;
  EXPECT_EQ(audit.head, audited(path).head);
}

TEST(Audit, WhatIsNoRunFileIsTamperedAndWhatIsNotThereIsAnError) {
  const Scratch scratch(true);
  EXPECT_EQ(audited(scratch.write("text.dwell", "time,x\n")).state, AuditState::tampered);
  EXPECT_EQ(audited(scratch.write("b.dwell", "")).state, AuditState::tampered);
  EXPECT_FALSE(audit_run(scratch.path("c.dwell"), {}));
  EXPECT_FALSE(audit_run(scratch.path(), {}));
  const Ledger ledger = recorded(scratch, 1);
  const auto ledgers = audit_run(scratch.path("ledger.dwell-ledger"), {});
  ASSERT_FALSE(ledgers);
  EXPECT_TRUE(says(ledgers.error(), "is a ledger, no run file")) << ledgers.error();
  EXPECT_FALSE(
      audit_run(scratch.path("a.dwell"), {.keys = {}, .ledger = scratch.path("none"), .anchors = {}, .progress = {}}));
}

TEST(Audit, SignaturesAreListedWithWhoVouches) {
  const Scratch scratch(true);
  const std::string path = scratch.path("a.dwell");
  write_sample(path, {.seed = 6, .end = SampleEnd::signed_by_both});
  const Audit audit = audited(path);
  ASSERT_EQ(audit.state, AuditState::intact) << audit.where;
  ASSERT_EQ(audit.signatures.size(), 2u);
  const std::string countersigned = audit.signatures[0].text, own = audit.signatures[1].text;
  EXPECT_TRUE(says(countersigned, "Anna Huber: reviewed")) << countersigned;
  EXPECT_TRUE(says(countersigned, "countersigned by the service for user 1000 (anna)")) << countersigned;
  EXPECT_TRUE(says(own, "with the key somebody")) << own;
  EXPECT_TRUE(says(own, ", not trusted")) << own;
}

TEST(Audit, ASignatureByAPinnedPersonsKeySaysSoAndOneByAnotherKeyIsNotTrusted) {
  const Scratch scratch(true);
  const std::string path = scratch.path("a.dwell");
  write_sample(path, {.seed = 6, .end = SampleEnd::signed_by_service});
  const auto anna = SigningKey::make("anna@desk"), eve = SigningKey::make("anna@desk");
  for (const auto* key : {&*anna, &*eve}) ASSERT_TRUE(sign_by_own_key(path, sample_words(), *key));
  AuditOptions options;
  options.persons = {anna->public_key()};
  const Audit audit = audited(path, options);
  ASSERT_EQ(audit.state, AuditState::intact) << audit.where;
  ASSERT_EQ(audit.signatures.size(), 3u);
  const AuditedSignature &service = audit.signatures[0], &hers = audit.signatures[1], &forged = audit.signatures[2];
  EXPECT_FALSE(service.trusted) << "the service's own key is not pinned";
  EXPECT_TRUE(hers.trusted);
  EXPECT_EQ(hers.key, anna->public_key().fingerprint());
  EXPECT_TRUE(says(hers.text, "with the pinned key anna@desk " + hers.key)) << hers.text;
  EXPECT_FALSE(forged.trusted) << "the same name, another key";
  EXPECT_TRUE(says(forged.text, "with the key anna@desk " + forged.key + ", not trusted")) << forged.text;
}

TEST(Audit, ASignatureThatNobodyVouchesForIsTampered) {
  const Scratch scratch(true);
  const std::string path = scratch.path("a.dwell");
  write_sample(path, {.seed = 6, .end = SampleEnd::signed_by_service});
  // As a forger: the service's signature without its note, another's name in a signature of one's own.
  Files files = files_in(scratch);
  ASSERT_TRUE(forge(path, "DELETE FROM note WHERE seq = (SELECT max(seq) FROM entry)"));
  EXPECT_TRUE(says(audited(path).where, "is not signed")) << audited(path).where;
  put_files(scratch, files);
  ASSERT_TRUE(forge(path,
                    "UPDATE entry SET body = CAST(replace(CAST(body AS TEXT), 'Anna', 'Emma') AS BLOB) "
                    "WHERE kind = 'signature'"));
  forge_heads(path);
  EXPECT_EQ(audited(path).state, AuditState::tampered);

  const std::string own = scratch.path("b.dwell");
  write_sample(own, {.seed = 7, .end = SampleEnd::signed_by_own_key});
  ASSERT_TRUE(
      forge(own,
            "UPDATE entry SET body = CAST(replace(CAST(body AS TEXT), '\"name\":\"Anna', '\"name\":\"Emma') AS BLOB) "
            "WHERE kind = 'signature'"));
  forge_heads(own);
  EXPECT_TRUE(says(audited(own).where, "its own note signs something else")) << audited(own).where;
}

TEST(Audit, OnlySignaturesMayFollowTheEnd) {
  const Scratch scratch(true);
  const std::string path = scratch.path("a.dwell");
  write_sample(path, {.seed = 6});
  {
    ChainWriter file =
        *ChainWriter::open(path, ChainSort::run, "dwell/run/" + sample_header(7, sample_key()).id, sample_key());
    ASSERT_TRUE(file.append("event", 0, "{}"));
    ASSERT_TRUE(file.close());
  }
  EXPECT_TRUE(says(audited(path).where, "after the end")) << audited(path).where;
}

TEST(Audit, AJournalBesideARunOrALedgerIsTamperingAndIsNeverPlayedBack) {
  const Scratch scratch;
  (void)recorded(scratch, 1);
  PersonalSignature words = sample_words();
  words.person = Person{1000, "anna"};
  const std::string run = scratch.path("a.dwell");
  for (const char* stray : {"a.dwell-journal", "a.dwell-wal"}) {
    scratch.write(stray, "from elsewhere");
    const Files before = files_in(scratch);
    const Audit audit = audited(run);
    EXPECT_EQ(audit.state, AuditState::tampered);
    EXPECT_TRUE(says(audit.where, std::string(stray).substr(7) + " lies beside it")) << audit.where;
    for (const auto& signature :
         {sign_by_own_key(run, words, sample_other()), sign_by_service(run, words, sample_key())}) {
      ASSERT_FALSE(signature);
      EXPECT_TRUE(says(signature.error(), " lies beside it")) << signature.error();
    }
    EXPECT_EQ(files_in(scratch), before);
    std::filesystem::remove(scratch.path(stray));
  }
  EXPECT_EQ(audited(run).state, AuditState::intact);
  scratch.write("ledger.dwell-ledger-journal", "");
  const auto ledger = Ledger::open(scratch.path(), sample_key());
  ASSERT_FALSE(ledger);
  EXPECT_TRUE(says(ledger.error(), "-journal lies beside it")) << ledger.error();
}

TEST(Audit, OnlyAClosedRunIsSignedAndOnlyByTheKeyThatRecordedIt) {
  const Scratch scratch(true);
  PersonalSignature signature = sample_words();
  signature.person = Person{1000, "anna"};
  const std::string open = scratch.path("a.dwell"), closed = scratch.path("b.dwell");
  write_sample(open, {.seed = 6, .end = SampleEnd::log_left});
  write_sample(closed, {.seed = 6});
  const Files before = files_in(scratch);
  EXPECT_FALSE(sign_by_service(open, signature, sample_key(), {}));
  EXPECT_FALSE(sign_by_own_key(open, signature, sample_other(), {}));
  const auto of_another = sign_by_service(closed, signature, sample_other());
  ASSERT_FALSE(of_another);
  EXPECT_FALSE(says(of_another.error(), "no longer")) << "the key may be that of another rig: " << of_another.error();
  EXPECT_TRUE(says(of_another.error(), "and the service signs with " + sample_other().public_key().fingerprint() +
                                           " now; sign with a key of your own"))
      << of_another.error();
  EXPECT_EQ(files_in(scratch), before);
  signature.reason = "two\nlines";
  EXPECT_FALSE(sign_by_own_key(closed, signature, sample_other()));
  EXPECT_EQ(audited(closed).state, AuditState::intact);
}

TEST(Audit, AnAnchorTellsACutTailFromACrash) {
  const Scratch scratch(true);
  const std::string path = scratch.path("a.dwell");
  const std::string head = write_sample(path, {.seed = 6, .end = SampleEnd::log_left});
  const auto seq = static_cast<std::int64_t>(rows_of(path).size());
  const Anchor anchor{"2026-11-23T03:12:20.000000Z", "dwell/run/" + sample_header(7, sample_key()).id, seq,
                      *from_hex(head)};
  const Audit whole = audited(path, with_anchors(scratch, to_line(anchor) + "\n"));
  EXPECT_EQ(whole.state, AuditState::open);
  EXPECT_EQ(whole.anchored_heads, 1u);
  std::filesystem::resize_file(path + "-wal", std::filesystem::file_size(path + "-wal") - 30000);
  EXPECT_EQ(audited(path).state, AuditState::open) << "as after a crash";
  const Audit cut = audited(path, with_anchors(scratch, to_line(anchor) + "\n"));
  EXPECT_EQ(cut.state, AuditState::tampered);
  EXPECT_TRUE(says(cut.where, "cut after entry ")) << cut.where;
  EXPECT_TRUE(says(cut.where, "the anchor of 2026-11-23T03:12:20.000000Z knows entry " + std::to_string(seq)))
      << cut.where;

  Anchor other = anchor;
  other.seq = 2;
  EXPECT_TRUE(says(audited(path, with_anchors(scratch, to_line(other))).where, "another chain"));
}

TEST(Audit, TheLedgerMakesItsRunsKnown) {
  const Scratch scratch(true);
  const Ledger ledger = recorded(scratch, 3, true);
  for (const char* name : {"a.dwell", "b.dwell"}) {
    const Audit audit = audited(scratch.path(name), with_ledger(scratch));
    EXPECT_EQ(audit.state, AuditState::intact) << audit.where;
    EXPECT_TRUE(audit.of_ledger);
  }
  EXPECT_EQ(audited(scratch.path("c.dwell"), with_ledger(scratch)).state, AuditState::open);
  // What was cut after the service took note of it.
  const std::string log = scratch.path("c.dwell-wal");
  std::filesystem::resize_file(log, std::filesystem::file_size(log) - 20000);
  EXPECT_TRUE(says(audited(scratch.path("c.dwell"), with_ledger(scratch)).where, "the ledger knows entry "));
  // A run of this key that the ledger has never seen.
  write_sample(scratch.path("d.dwell"), {.seed = 9});
  EXPECT_TRUE(says(audited(scratch.path("d.dwell"), with_ledger(scratch)).where, "does not know run 10"));
  write_sample(scratch.path("e.dwell"), {.seed = 1, .header = sample_header(2, sample_key())});
  EXPECT_EQ(audited(scratch.path("e.dwell"), with_ledger(scratch)).state, AuditState::tampered);
}

TEST(Audit, ARemovedRunIsFoundAndADeletedOneIsNotTampering) {
  const Scratch scratch(true);
  Ledger ledger = recorded(scratch, 4);
  const AuditOptions none;
  const std::string path = scratch.path("ledger.dwell-ledger");
  Result<LedgerAudit> audit = audit_ledger(path, scratch.path(), none);
  ASSERT_TRUE(audit) << audit.error();
  EXPECT_TRUE(audit->unbroken) << audit->where;
  EXPECT_TRUE(audit->missing.empty());

  ASSERT_TRUE(ledger.run_deleted(1, "older than 90 days"));
  std::filesystem::remove(scratch.path("a.dwell"));
  std::filesystem::remove(scratch.path("c.dwell"));
  std::filesystem::rename(scratch.path("d.dwell"), scratch.path("b.dwell"));
  audit = audit_ledger(path, scratch.path(), none);
  EXPECT_TRUE(audit->unbroken);
  ASSERT_EQ(audit->deleted.size(), 1u);
  EXPECT_TRUE(says(audit->deleted[0], "older than 90 days")) << audit->deleted[0];
  ASSERT_EQ(audit->missing.size(), 3u);
  EXPECT_TRUE(says(audit->missing[0], "run 2") && says(audit->missing[0], "another run")) << audit->missing[0];
  EXPECT_TRUE(says(audit->missing[1], "run 3")) << audit->missing[1];
}

TEST(Audit, ASignatureThatTheLedgerKnowsCannotBeTakenAway) {
  const Scratch scratch(true);
  Ledger ledger = recorded(scratch, 1);
  const std::string path = scratch.path("a.dwell");
  const std::string before = Scratch::read(path);
  PersonalSignature signature;
  signature.name = "Anna";
  signature.meaning = "reviewed";
  signature.utc = "2026-11-24T08:00:00.000000Z";
  signature.person = Person{1000, "anna"};
  const Result<PersonalSignature> signed_ = sign_by_service(path, signature, sample_key());
  ASSERT_TRUE(signed_) << signed_.error();
  ASSERT_TRUE(ledger.run_signed(1, *signed_));
  EXPECT_EQ(audited(path, with_ledger(scratch)).state, AuditState::intact) << audited(path, with_ledger(scratch)).where;
  scratch.write("a.dwell", before);
  EXPECT_EQ(audited(path).state, AuditState::intact) << "only the ledger knows";
  EXPECT_TRUE(says(audited(path, with_ledger(scratch)).where, "the signature of Anna"));
}

TEST(Audit, TheLedgerCutTogetherWithTheNewestRunsIsFoundOnlyByAnAnchor) {
  const Scratch scratch(true);
  Files short_before;
  Anchor anchor;
  {
    Ledger ledger = recorded(scratch, 2);
    short_before = files_in(scratch);
    RunHeader header = sample_header(3, sample_key());
    header.previous_head = ledger.newest_head();
    ASSERT_TRUE(ledger.run_begins(header, "c.dwell"));
    anchor = ledger.head();
    anchor.utc = "2026-11-23T05:00:00.000000Z";
  }
  put_files(scratch, short_before);
  const std::string path = scratch.path("ledger.dwell-ledger");
  EXPECT_TRUE(audit_ledger(path, scratch.path(), {})->unbroken);
  const auto audit = audit_ledger(path, scratch.path(), with_anchors(scratch, to_line(anchor)));
  EXPECT_FALSE(audit->unbroken);
  EXPECT_TRUE(says(audit->where, "cut after entry ")) << audit->where;
  Anchor of_run = anchor;
  of_run.origin = "dwell/run/" + sample_header(3, sample_key()).id;
  EXPECT_EQ(audit_ledger(path, scratch.path(), with_anchors(scratch, to_line(of_run)))->missing.size(), 1u);
}

// The audit had read the ledger a moment before, and called the run missing.
TEST(Audit, ARunThatRetentionDeletesWhileTheLedgerIsAuditedIsNotMissing) {
  const Scratch scratch(true);
  Ledger ledger = recorded(scratch, 1);
  const std::string path = scratch.path("ledger.dwell-ledger");
  AuditOptions options;
  auto before = check_ledger(path, options);
  ASSERT_TRUE(before) << before.error();
  options.checked = std::make_shared<const CheckedLedger>(std::move(*before));
  ASSERT_TRUE(ledger.run_deleted(1, "older than 90 days"));
  std::filesystem::remove(scratch.path("a.dwell"));
  const auto audit = audit_ledger(path, scratch.path(), options);
  ASSERT_TRUE(audit) << audit.error();
  EXPECT_TRUE(audit->missing.empty()) << audit->missing[0];
  EXPECT_EQ(audit->deleted.size(), 1U);
}

// Whoever damages the file of a run that was cut off makes the service enter its end without a head.
TEST(Audit, ARunWithoutAnEntryByTheLedgerIsMissingWhereAnAnchorKnowsAnEntry) {
  const Scratch scratch(true);
  Ledger ledger = recorded(scratch, 1);
  RunHeader header = sample_header(2, sample_key());
  header.previous_head = ledger.newest_head();
  ASSERT_TRUE(ledger.run_begins(header, "b.dwell"));
  ASSERT_TRUE(ledger.run_ends({2, "", 0, "cut off"}));
  ASSERT_TRUE(ledger.run_deleted(2, "older than 90 days"));
  const std::string path = scratch.path("ledger.dwell-ledger");
  EXPECT_TRUE(audit_ledger(path, scratch.path(), {})->missing.empty());
  Anchor anchor = ledger.head();
  anchor.utc = "2026-11-23T05:00:00.000000Z";
  anchor.origin = "dwell/run/" + header.id;
  const auto audit = audit_ledger(path, scratch.path(), with_anchors(scratch, to_line(anchor)));
  ASSERT_EQ(audit->missing.size(), 1u);
  EXPECT_TRUE(says(audit->missing[0], "the anchors know one")) << audit->missing[0];
}

TEST(Audit, KeysAreConnectedByTheLedger) {
  const Scratch scratch(true);
  {
    Ledger ledger = recorded(scratch, 1);
    ASSERT_TRUE(ledger.key_changes(sample_other().public_key()));
  }
  {
    Ledger ledger = *Ledger::open(scratch.path(), sample_other());
    RunHeader header = sample_header(2, sample_other());
    header.previous_head = ledger.newest_head();
    ASSERT_TRUE(ledger.run_begins(header, "b.dwell"));
    const std::string head = write_sample(scratch.path("b.dwell"), {.seed = 4, .header = header}, sample_other());
    ASSERT_TRUE(
        ledger.run_ends({2, head, static_cast<std::int64_t>(rows_of(scratch.path("b.dwell")).size()), "closed"}));
  }
  for (const SigningKey* key : {&sample_key(), &sample_other()}) {
    AuditOptions options = with_ledger(scratch);
    options.keys = {key->public_key()};
    for (const char* name : {"a.dwell", "b.dwell"}) {
      const Audit audit = audited(scratch.path(name), options);
      EXPECT_EQ(audit.state, AuditState::intact) << audit.where;
      EXPECT_TRUE(audit.trusted);
    }
  }
  AuditOptions options = with_ledger(scratch);
  options.keys = {SigningKey::make("third")->public_key()};
  EXPECT_FALSE(audit_ledger(options.ledger, scratch.path(), options)->unbroken);
  EXPECT_EQ(audited(scratch.path("a.dwell"), options).state, AuditState::tampered);
}

TEST(Audit, AnAlteredLedgerIsBrokenAndMakesNothingTrusted) {
  const Scratch scratch(true);
  { const Ledger ledger = recorded(scratch, 3); }
  const std::string path = scratch.path("ledger.dwell-ledger");
  const Files before = files_in(scratch);
  for (const char* sql :
       {"DELETE FROM entry WHERE seq = 4", "DELETE FROM note WHERE seq = 3", "UPDATE entry SET t_ns = 0 WHERE seq = 2",
        "DELETE FROM entry WHERE seq = 4; UPDATE entry SET seq = seq - 1 WHERE seq > 4; DELETE FROM note WHERE seq = 7",
        "DROP TABLE note", "DELETE FROM entry; DELETE FROM note"}) {
    put_files(scratch, before);
    ASSERT_TRUE(forge(path, sql)) << sql;
    EXPECT_FALSE(audit_ledger(path, scratch.path(), {})->unbroken) << sql;
    EXPECT_FALSE(audited(scratch.path("a.dwell"), with_ledger(scratch)).trusted) << sql;
  }
}

}  // namespace
}  // namespace dwell::record
