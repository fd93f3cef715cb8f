#pragma once

#include <algorithm>
#include <vector>

#include "saved_state.h"
#include "smooth_patches.h"

namespace flipflow {

// What a contact model remembers about the surface contacts of each particle: `values` numbers
// per contact, kept with the contact's normal.  A contact that wanders from one triangle to the
// next is known by its normal and keeps its values.  A new contact that is near to one (another
// place of the same smooth patch) starts with a copy of that one's.
class ContactHistory {
 public:
  explicit ContactHistory(int values) : record_(3 + values) {}

  // Makes the records of particle i those of its present contacts, in their order.
  void match(int i, std::vector<Touch> &touches) {
    std::vector<double> &records = records_[i];
    if (records.empty() && touches.empty()) return;
    for (size_t k = 0; k < touches.size(); ++k) touches[k].record = static_cast<int>(k);
    if (touches.size() == 1 && goes_on(records.data(), records.size(), touches[0])) return;
    old_.swap(records);
    taken_.assign(old_.size() / record_, false);
    records.assign(touches.size() * record_, 0.0);
    pair_up(touches);
    for (size_t k = 0; k < touches.size(); ++k) {
      const Vec3 normal = normal_of(touches[k]);
      const int heir_of = same_[k] >= 0 ? same_[k] : find_nearest(normal, kSamePatch, true).row;
      double *record = &records[k * record_];
      if (heir_of >= 0) std::copy_n(&old_[heir_of * record_], record_, record);
      put(record, normal);
    }
  }

  // Leaves those records of particle i that belong to `touches`, which are in the order of the records.
  void keep(int i, const std::vector<Touch> &touches) {
    std::vector<double> &records = records_[i];
    for (size_t k = 0; k < touches.size(); ++k) {
      const auto from = records.begin() + touches[k].record * record_;
      if (static_cast<size_t>(touches[k].record) != k) std::copy_n(from, record_, &records[k * record_]);
    }
    records.resize(touches.size() * record_);
  }

  double *values(int i, int contact) { return &records_[i][contact * record_ + 3]; }

  // Asks memory for the records of particle i, which are soon wanted, and first for where they are.
  void fetch_place(int i) const { __builtin_prefetch(&records_[i]); }
  void fetch(int i) const {
    constexpr int kLine = 64 / sizeof(double);
    for (int at = 0; at < record_; at += kLine) __builtin_prefetch(records_[i].data() + at);
  }

  void resize(int particles) { records_.resize(particles); }
  void copy(int from, int to) { records_[to] = records_[from]; }
  void forget(int i) { records_[i].clear(); }

  // both return how many numbers they used
  int pack(int i, double *buffer) const {
    buffer[0] = static_cast<double>(records_[i].size());
    std::copy(records_[i].begin(), records_[i].end(), buffer + 1);
    return 1 + static_cast<int>(records_[i].size());
  }

  int unpack(int i, const double *buffer) {
    const int size = static_cast<int>(buffer[0]);
    records_[i].assign(buffer + 1, buffer + 1 + size);
    return 1 + size;
  }

  void save(int particles, SavedState &saved) const {
    auto &sizes = saved.wholes["surface_history_size"];
    auto &values = saved.reals["surface_history"];
    for (int i = 0; i < particles; ++i) {
      sizes.push_back(static_cast<std::int64_t>(records_[i].size()));
      values.insert(values.end(), records_[i].begin(), records_[i].end());
    }
  }

  void restore(const SavedState &saved) {
    auto from = saved.real("surface_history").begin();
    int i = 0;
    for (const std::int64_t size : saved.whole("surface_history_size")) {
      records_[i++].assign(from, from + size);
      from += size;
    }
  }

  int packed_size(int contacts) const { return 1 + contacts * record_; }

 private:
  static constexpr double kSameContact = 0.5;  // least cosine between old and new normal
  static constexpr double kSamePatch = 0.86602540378443865;  // cos 30 degrees

  static Vec3 normal_of(const Touch &touch) { return (1.0 / std::sqrt(touch.distance2)) * touch.away; }

  // Is the only contact the one that is remembered as the only one?  That is so nearly always.
  bool goes_on(double *record, size_t size, const Touch &touch) const {
    const Vec3 normal = normal_of(touch);
    if (size != static_cast<size_t>(record_) || dot(normal, from(record)) <= kSameContact) return false;
    put(record, normal);
    return true;
  }

  // Which old records go on, nearest normals first: `same_` of each contact, or -1.
  void pair_up(const std::vector<Touch> &touches) {
    same_.assign(touches.size(), -1);
    for (;;) {
      Nearest nearest = {-1, kSameContact};
      size_t of = 0;
      for (size_t k = 0; k < touches.size(); ++k) {
        if (same_[k] >= 0) continue;
        const Nearest found = find_nearest(normal_of(touches[k]), nearest.cosine, false);
        if (found.row < 0) continue;
        nearest = found;
        of = k;
      }
      if (nearest.row < 0) return;
      same_[of] = nearest.row;
      taken_[nearest.row] = true;
    }
  }

  struct Nearest {
    int row;  // -1: none
    double cosine;
  };
  // The old record with the nearest normal that is nearer than `least_cosine`.
  Nearest find_nearest(Vec3 normal, double least_cosine, bool taken_ones) const {
    Nearest nearest = {-1, least_cosine};
    for (size_t old = 0; old < taken_.size(); ++old) {
      const double cosine = dot(normal, from(&old_[old * record_]));
      if (cosine > nearest.cosine && (taken_ones || !taken_[old])) nearest = {static_cast<int>(old), cosine};
    }
    return nearest;
  }

  int record_;                                // 3 of the normal, then the values
  std::vector<std::vector<double>> records_;  // of each particle, one contact after the other
  std::vector<double> old_;
  std::vector<bool> taken_;  // of the old records
  std::vector<int> same_;    // of the contacts
};

}  // namespace flipflow
