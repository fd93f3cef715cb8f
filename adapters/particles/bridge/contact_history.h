#pragma once

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
  void match(int i, const std::vector<Touch> &touches);
  double *values(int i, int contact) { return &records_[i][contact * record_ + 3]; }

  void resize(int particles) { records_.resize(particles); }
  void copy(int from, int to) { records_[to] = records_[from]; }
  void forget(int i) { records_[i].clear(); }
  int pack(int i, double *buffer) const;  // both return how many numbers they used
  int unpack(int i, const double *buffer);
  void save(int particles, SavedState &saved) const;
  void restore(const SavedState &saved);
  int packed_size(int contacts) const { return 1 + contacts * record_; }

 private:
  int find_nearest(Vec3 normal, double least_cosine, bool taken_ones) const;

  int record_;                                // 3 of the normal, then the values
  std::vector<std::vector<double>> records_;  // of each particle, one contact after the other
  std::vector<double> old_;
  std::vector<bool> taken_;  // of the old records
};

}  // namespace flipflow
