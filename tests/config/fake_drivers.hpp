// Drivers as far as the rig file sees them: key schemas and a check, nothing behind. Rig file texts to test with.
#pragma once

#include <string>
#include <string_view>

#include "config/rig_file.hpp"

namespace dwell::config::testing {

// Knows "modbus", "replay" and "picky"; the keys of the first two are those of the shipped plugins that the sample rigs
// use. "picky" has one key of each type and a check that objects to whatever holds the word "odd".
[[nodiscard]] SchemaSource fake_schemas();

// A clamped two-mass rig without a mistake, every section but [gpio] in it.
extern const std::string_view kGoodRig;

// kGoodRig with the one place where `old_text` stands replaced; old_text empty: new_text appended. `new_text` may hold
// a mark "@" where a mistake is expected; position() tells where it stood, and text is without it.
struct Edited {
  std::string text;
  Position position;
};
[[nodiscard]] Edited edited(std::string_view old_text, std::string_view new_text);

// The mistakes in the text, one per line as printed; empty: none.
[[nodiscard]] std::string mistakes_in(std::string_view text, const SchemaSource& schemas = fake_schemas());

// Expects that the edit makes exactly one mistake, at the mark, with this message.
void expect_mistake(std::string_view old_text, std::string_view new_text, const std::string& message,
                    const SchemaSource& schemas = fake_schemas());
// Expects that the file is good with the edit.
void expect_good(std::string_view old_text, std::string_view new_text, const SchemaSource& schemas = fake_schemas());

}  // namespace dwell::config::testing
