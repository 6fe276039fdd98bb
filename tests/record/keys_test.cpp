#include "daemon/record/keys.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>
#include <string>

#include "tests/record/scratch.hpp"

namespace dwell::record {
namespace {

// The example of Go's golang.org/x/mod/sumdb/note, where the format comes from.
const std::string kPeter = "PeterNeumann+c74f20a3+ARpc2QcUPDhMQegwxbzhKqiBfsVkmqq/LDE4izWy10TW";
const std::string kPeterPrivate = "PRIVATE+KEY+PeterNeumann+c74f20a3+AYEKFALVFGyNhPJEMzD1QIDr+Y7hfZx09iUvxdXHKDFz\n";
const std::string kPeterText =
    "If you think cryptography is the answer to your problem,\n"
    "then you don't know what your problem is.\n";
const std::string kPeterNote =
    kPeterText +
    "\n\u2014 PeterNeumann x08go/ZJkuBS9UG/SffcvIAQxVBtiFupLLr8pAcElZInNIuGUgYN1FFYC2pZSNXgKvqfqdng"
    "otpRZb6KE6RyyBwJnAM=\n";

TEST(Keys, APublishedNoteOpensAndIsSignedToTheSameBytes) {
  const Scratch scratch;
  const std::string path = scratch.write("key", kPeterPrivate);
  ::chmod(path.c_str(), 0600);
  const Result<SigningKey> key = SigningKey::load(path);
  ASSERT_TRUE(key) << key.error();
  EXPECT_EQ(key->public_key().vkey(), kPeter);
  EXPECT_EQ(key->sign(kPeterText), kPeterNote);
  const Result<PublicKey> peter = PublicKey::parse(kPeter);
  ASSERT_TRUE(peter) << peter.error();
  EXPECT_EQ(*peter, key->public_key());
  EXPECT_EQ(peter->open(kPeterNote).value_or("?"), kPeterText);
}

TEST(Keys, APublicKeyWithAnyBitFlippedOrByteGoneIsRefused) {
  for (std::size_t i = 0; i < kPeter.size(); ++i) {
    for (int bit = 0; bit < 8; ++bit) {
      std::string other = kPeter;
      other[i] = static_cast<char>(other[i] ^ 1 << bit);
      EXPECT_FALSE(PublicKey::parse(other)) << other;
    }
    EXPECT_FALSE(PublicKey::parse(kPeter.substr(0, i)));
    EXPECT_FALSE(PublicKey::parse(kPeter.substr(i + 1)));
  }
  // A key of another length and one of an unknown algorithm, each with the hash that fits.
  EXPECT_FALSE(PublicKey::parse("PeterNeumann+cc469956+ARpc2QcUPDhMQegwxbzhKqiBfsVkmqq/LDE4izWy10TWBADKEY=="));
  EXPECT_FALSE(PublicKey::parse("PeterNeumann+173116ae+ZRpc2QcUPDhMQegwxbzhKqiBfsVkmqq/LDE4izWy10TW"));
}

TEST(Keys, ANoteWithAnyBitFlippedIsRefused) {
  const PublicKey peter = *PublicKey::parse(kPeter);
  for (std::size_t i = 0; i < kPeterNote.size(); ++i) {
    for (int bit = 0; bit < 8; ++bit) {
      std::string other = kPeterNote;
      other[i] = static_cast<char>(other[i] ^ 1 << bit);
      EXPECT_FALSE(peter.open(other)) << "bit " << bit << " of byte " << i;
    }
  }
  for (std::size_t i = 0; i < kPeterNote.size(); ++i) EXPECT_FALSE(peter.open(kPeterNote.substr(0, i)));
  EXPECT_FALSE(peter.open(kPeterNote + "\n"));
  EXPECT_FALSE(peter.open(kPeterNote + kPeterNote.substr(kPeterText.size() + 1)));
  EXPECT_FALSE(peter.open("\n" + kPeterNote));
}

TEST(Keys, ASavedKeyIsTheSameWhenLoadedAndNobodyElseMayReadIt) {
  const Scratch scratch;
  const Result<SigningKey> key = SigningKey::make("rig-7.example.org");
  ASSERT_TRUE(key) << key.error();
  const std::string path = scratch.path("key");
  ASSERT_TRUE(key->save(path));
  struct stat status {};
  ASSERT_EQ(::stat(path.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777u, 0600u);
  const Result<SigningKey> loaded = SigningKey::load(path);
  ASSERT_TRUE(loaded) << loaded.error();
  EXPECT_EQ(loaded->public_key(), key->public_key());
  EXPECT_EQ(key->public_key().open(loaded->sign("a\n")).value_or("?"), "a\n");

  EXPECT_FALSE(key->save(path)) << "an existing key is never overwritten";
  ::chmod(path.c_str(), 0640);
  EXPECT_FALSE(SigningKey::load(path));
}

TEST(Keys, ADamagedPrivateKeyIsRefused) {
  const Scratch scratch;
  for (std::size_t i = 0; i < kPeterPrivate.size(); ++i) {
    std::string other = kPeterPrivate;
    other[i] = static_cast<char>(other[i] ^ 1);
    const std::string path = scratch.write("key" + std::to_string(i), other);
    ::chmod(path.c_str(), 0600);
    EXPECT_FALSE(SigningKey::load(path)) << other;
  }
}

TEST(Keys, TwoKeysOfOneNameAreToldApart) {
  const SigningKey one = *SigningKey::make("rig"), other = *SigningKey::make("rig");
  EXPECT_NE(one.public_key().fingerprint(), other.public_key().fingerprint());
  EXPECT_EQ(one.public_key().fingerprint().size(), 16 * 4 + 15u);
  EXPECT_FALSE(other.public_key().open(one.sign("a\n")));
}

TEST(Keys, NamesThatANoteCannotHoldAreRefused) {
  for (const char* name : {"", "a b", "a+b", "a\nb", "\u00fc", "\x7f"}) EXPECT_FALSE(SigningKey::make(name)) << name;
}

}  // namespace
}  // namespace dwell::record
