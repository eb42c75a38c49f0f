#include "musher/behavior/tree/board.hpp"

#include <algorithm>

namespace musher::tree {

Result<> Entry::Assign(const Value& from) {
  if (type == nullptr || from.type() == type) {
    value = from;
  } else if (Result<> converted = value.SetAs(*type, from); !converted) {
    return converted;
  }
  NoteSet();
  return Ok();
}

Result<> Entry::AssignNumber(double number) {
  if (type == nullptr) {
    value.Set(number);
  } else if (Result<> converted = value.SetNumberAs(*type, number); !converted) {
    return converted;
  }
  NoteSet();
  return Ok();
}

Result<> Entry::AssignText(std::string_view text) {
  if (type == nullptr) {
    value.SetText(text);
  } else if (Result<> converted = value.SetTextAs(*type, text); !converted) {
    return converted;
  }
  NoteSet();
  return Ok();
}

Entry& Board::At(std::string_view key) {
  if (key.starts_with('@')) return Outermost().At(key.substr(1));
  const auto found = entries_.find(key);
  if (found != entries_.end()) return *found->second;
  if (!autoremap_ || parent_ == nullptr || key.starts_with('_')) return Own(key);
  Entry& outer = parent_->At(key);
  entries_.emplace(key, &outer);
  return outer;
}

Entry* Board::Find(std::string_view key) {
  if (key.starts_with('@')) return Outermost().Find(key.substr(1));
  const auto found = entries_.find(key);
  if (found != entries_.end()) return found->second;
  const bool outer = autoremap_ && parent_ != nullptr && !key.starts_with('_');
  return outer ? parent_->Find(key) : nullptr;
}

const Board& Board::Outermost() const {
  const Board* outermost = this;
  while (outermost->parent_ != nullptr) outermost = outermost->parent_;
  return *outermost;
}

void Board::Remap(std::string_view key, std::string_view outer) {
  entries_.insert_or_assign(std::string(key), &parent_->At(outer));
}

Entry& Board::Own(std::string_view key) {
  own_.push_back(std::make_unique<Entry>());
  own_.back()->key = key;
  own_.back()->clock = clock_;
  entries_.insert_or_assign(std::string(key), own_.back().get());
  return *own_.back();
}

bool Board::Owns(std::string_view key) const {
  const auto found = entries_.find(key);
  return found != entries_.end() &&
         std::ranges::find(own_, found->second, &std::unique_ptr<Entry>::get) != own_.end();
}

std::size_t Board::size() const {
  return entries_.size() + (kept_ == nullptr ? 0 : Outermost().entries_.size());
}

std::vector<std::string> Board::Keys() const {
  std::vector<std::string> keys;
  if (kept_ != nullptr) {
    for (const auto& [key, entry] : Outermost().entries_) keys.push_back("@" + key);
  }
  for (const auto& [key, entry] : entries_) keys.push_back(key);
  std::ranges::sort(keys);
  return keys;
}

}  // namespace musher::tree
