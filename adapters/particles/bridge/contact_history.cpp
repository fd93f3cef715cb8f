#include "contact_history.h"

#include <algorithm>

namespace flipflow {

namespace {

constexpr double kSameContact = 0.5;  // least cosine between a contact's old and new normal

}  // namespace

void ContactHistory::match(int i, const std::vector<Touch> &touches) {
  std::vector<double> &records = records_[i];
  if (records.empty() && touches.empty()) return;
  old_.swap(records);
  records.assign(touches.size() * record_, 0.0);
  for (size_t k = 0; k < touches.size(); ++k) {
    const Vec3 normal = (1.0 / std::sqrt(touches[k].distance2)) * touches[k].away;
    double nearest = kSameContact;
    double *match = nullptr;
    for (size_t old = 0; old < old_.size(); old += record_) {
      const double cosine = dot(normal, from(&old_[old]));
      if (cosine > nearest) {
        nearest = cosine;
        match = &old_[old];
      }
    }
    double *record = &records[k * record_];
    if (match) {
      std::copy(match, match + record_, record);
      match[0] = match[1] = match[2] = 0.0;  // taken
    }
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

int ContactHistory::unpack(int i, const double *buffer) {
  const int size = static_cast<int>(buffer[0]);
  records_[i].assign(buffer + 1, buffer + 1 + size);
  return 1 + size;
}

}  // namespace flipflow
