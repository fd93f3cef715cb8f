#include "contact_history.h"

#include <algorithm>

namespace flipflow {

namespace {

constexpr double kSameContact = 0.5;                  // least cosine between old and new normal
constexpr double kSamePatch = 0.86602540378443865;    // cos 30 degrees

}  // namespace

// The old record with the nearest normal, or -1.
int ContactHistory::find_nearest(Vec3 normal, double least_cosine, bool taken_ones) const {
  int row = -1;
  for (size_t old = 0; old < taken_.size(); ++old) {
    const double cosine = dot(normal, from(&old_[old * record_]));
    if (cosine > least_cosine && (taken_ones || !taken_[old])) {
      least_cosine = cosine;
      row = static_cast<int>(old);
    }
  }
  return row;
}

void ContactHistory::match(int i, const std::vector<Touch> &touches) {
  std::vector<double> &records = records_[i];
  if (records.empty() && touches.empty()) return;
  old_.swap(records);
  taken_.assign(old_.size() / record_, false);
  records.assign(touches.size() * record_, 0.0);
  for (size_t k = 0; k < touches.size(); ++k) {
    const Vec3 normal = (1.0 / std::sqrt(touches[k].distance2)) * touches[k].away;
    const int same = find_nearest(normal, kSameContact, false);
    const int heir_of = same >= 0 ? same : find_nearest(normal, kSamePatch, true);
    double *record = &records[k * record_];
    if (heir_of >= 0) std::copy_n(&old_[heir_of * record_], record_, record);
    if (same >= 0) taken_[same] = true;
    record[0] = normal.x;
    record[1] = normal.y;
    record[2] = normal.z;
  }
}

int ContactHistory::pack(int i, double *buffer) const {
  buffer[0] = static_cast<double>(records_[i].size());
  std::copy(records_[i].begin(), records_[i].end(), buffer + 1);
  return 1 + static_cast<int>(records_[i].size());
}

void ContactHistory::save(int particles, SavedState &saved) const {
  auto &sizes = saved.wholes["surface_history_size"];
  auto &values = saved.reals["surface_history"];
  for (int i = 0; i < particles; ++i) {
    sizes.push_back(static_cast<std::int64_t>(records_[i].size()));
    values.insert(values.end(), records_[i].begin(), records_[i].end());
  }
}

void ContactHistory::restore(const SavedState &saved) {
  auto from = saved.real("surface_history").begin();
  int i = 0;
  for (const std::int64_t size : saved.whole("surface_history_size")) {
    records_[i++].assign(from, from + size);
    from += size;
  }
}

int ContactHistory::unpack(int i, const double *buffer) {
  const int size = static_cast<int>(buffer[0]);
  records_[i].assign(buffer + 1, buffer + 1 + size);
  return 1 + size;
}

}  // namespace flipflow
