#pragma once

#include <yaml-cpp/yaml.h>

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "clothsim/model/types.h"

// Strict readers of single YAML values. All throw InvalidValue for a wrong type, with a key
// relative to the node they are given. A quoted scalar is text, never a number or a switch; in
// nodes made by a program, the tag "!" has the same meaning as quotes.

namespace clothsim {

/// `expected`: for the message, where other values are allowed, too.
double read_number(const YAML::Node&, const std::string& expected = "a finite number");
int read_int(const YAML::Node&, const std::string& expected = "a whole number");
bool read_switch(const YAML::Node&, const std::string& expected = "true or false");
std::string read_text(const YAML::Node&);  // not empty
Vector3 read_vector(const YAML::Node&);

/// Index in `choices` of the text in the node.
int read_choice(const YAML::Node&, const std::vector<std::string>& choices);

/// Is the node the text `word`, with or without quotes?
bool is_word(const YAML::Node&, const std::string& word);

/// The node in a few words for a message: `-5`, `"5" (text)`, `[1, 2]`, `a map`.
std::string describe(const YAML::Node&);

/// Nodes made by a program: a number with the fewest digits that restore it, and a quoted text.
YAML::Node number_node(double value);
YAML::Node text_node(const std::string& text);

using ReadValue = std::function<void(const YAML::Node&)>;

/// A key that a map may have, and the reader of its value.
struct Field {
  std::string key;
  ReadValue read;
};

/// Reads each key of the map. Throws for a repeated key or one that is not among `fields`.
void read_map(const YAML::Node&, const std::vector<Field>& fields);

/// Adds fields at the end.
void append(std::vector<Field> more, std::vector<Field>& fields);

/// Reads each item of a list; keys are "0", "1" and so on.
void read_list(const YAML::Node&, const std::function<void(const YAML::Node&)>& read_item);

/// Stores the value in `target`, which must outlive the reader.
ReadValue into(double& target);
ReadValue into(int& target);
ReadValue into(std::uint64_t& target);
ReadValue into(bool& target);
ReadValue into(std::string& target);
ReadValue into(Vector3& target);
ReadValue into(std::array<double, 2>& target);  // a list of two numbers, or one number for both
ReadValue into(std::optional<double>& target);  // a number, or off: empty

}  // namespace clothsim
