#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "../../vec3.h"
#include "saved_state.h"
#include "surface_path.h"

namespace flipflow {

// A deck of panels one after the other, seen from the side (DeckPlan in orchestrator/ports/plans.py).
struct DeckLine {
  Vec3 along, across;
  std::vector<int> points;        // of the surface, in the direction of flow
  std::vector<int> panel;         // of each point, its panel's place along the deck
  std::vector<double> station_m;  // of each point
  std::vector<double> open_m;     // of each panel: lowest and highest station, then place across
  double reach_m = 0.0;
  std::vector<double> half_depth_m;  // of each panel: how far its sides are from the line

  int panels() const { return static_cast<int>(open_m.size()) / 4; }
};

// Counts the contacts of each particle with the open mat, panel by panel, and how long it is over a panel and
// within reach of it (docs/theory/screening.md, "Why so much passes").
//
// A contact is an episode: it begins with a touch of the perforated part of a panel, or without one when the
// particle is through the mat, and is over at a sync point at which the gap below the particle is a quarter of
// its diameter and nothing touched since the last one.  Who is in an opening with a depth is not through it yet:
// gaps are those over the upper side, and a particle is through below the lower one.  Touches are noted in every step; heights over the
// line of the deck are looked at once an interval, so that this costs nothing that could be measured.
class DeckContacts {
 public:
  void set(DeckLine line, int particles) {
    line_ = std::move(line);
    width_ = line_.panels() ? kFirst + 3 * line_.panels() : 0;
    u_.resize(line_.points.size());
    z_.resize(line_.points.size());
    cosine_.resize(line_.points.size());
    resize(particles);
  }

  int width() const { return width_; }  // numbers of each particle; 0: nothing is counted
  // `width()` numbers of particle i: two of its own, contacts and seconds over and within reach of each panel
  const double *row(int i) const { return rows_.data() + static_cast<size_t>(width_) * i; }
  static constexpr int kLast = 0, kFirst = 2;  // places in a row: the panel of the last contact, or -1; the counts
  int panels() const { return line_.panels(); }

  void touched(int i) {
    if (width_ && row(i)[kState] < kTouched) mutable_row(i)[kState] += kTouched;
  }

  struct Grain {
    int row;
    Vec3 position_m;
    double radius_m;
  };

  // At the end of an interval of `length_s`: `grain(k)` is the k-th of `count`.
  template <class GrainAt>
  void observe(const SurfacePath &surface, int count, GrainAt grain, double length_s) {
    if (!width_) return;
    find_line(surface);
    const int panels = line_.panels();
    for (int k = 0; k < count; ++k) {
      const auto [i, position_m, radius_m] = grain(k);
      double *row = mutable_row(i);
      const bool touched = row[kState] >= kTouched;
      bool counted = is_counted(row);
      const Place place = locate(position_m);
      const double half_m = line_.half_depth_m[place.panel];
      const double gap_m = place.height_m - half_m - radius_m;
      const bool through = place.height_m < -half_m - radius_m;
      if (place.inside) {
        if (!counted && (through || (touched && place.open))) {
          count_contact(row, place.panel);
          counted = true;
        }
        if (!through) {
          row[kFirst + panels + place.panel] += length_s;
          if (gap_m < line_.reach_m) row[kFirst + 2 * panels + place.panel] += length_s;
        }
      }
      if (!touched && gap_m >= kOver * 2.0 * radius_m) counted = false;
      row[kState] = counted ? kCounted : 0.0;
    }
  }

  // A particle leaves through an exit below the deck, perhaps before it was seen to have touched or passed.
  void passes(const SurfacePath &surface, int i, Vec3 position_m) {
    if (!width_) return;
    double *row = mutable_row(i);
    if (is_counted(row)) return;
    find_line(surface);
    const Place place = locate(position_m);
    if (place.inside) count_contact(row, place.panel);
    row[kState] = kCounted;
  }

  void resize(int particles) { rows_.resize(static_cast<size_t>(width_) * particles); }
  void copy(int from, int to) {
    if (from != to) std::copy_n(row(from), width_, mutable_row(to));
  }
  void forget(int i) {
    if (!width_) return;
    std::fill_n(mutable_row(i), width_, 0.0);
    mutable_row(i)[kLast] = -1.0;
  }

  // both return how many numbers they used
  int pack(int i, double *buffer) const {
    if (width_) std::copy_n(row(i), width_, buffer);
    return width_;
  }
  int unpack(int i, const double *buffer) {
    if (width_) std::copy_n(buffer, width_, mutable_row(i));
    return width_;
  }

  void save(int particles, SavedState &saved) const {
    saved.reals["deck_contacts"] = {rows_.begin(), rows_.begin() + static_cast<long>(width_) * particles};
  }
  void restore(const SavedState &saved) {
    const auto &values = saved.real("deck_contacts");
    std::copy(values.begin(), values.end(), rows_.begin());
  }

 private:
  static constexpr int kState = 1;  // place in a row
  static constexpr double kCounted = 1.0, kTouched = 2.0;  // parts of the state
  static constexpr double kOver = 0.25;  // diameters of gap at which a contact is over

  struct Place {
    int panel;
    double height_m;  // normal to the line, of the centre
    bool inside, open;
  };

  double *mutable_row(int i) { return rows_.data() + static_cast<size_t>(width_) * i; }

  static bool is_counted(const double *row) {
    return row[kState] == kCounted || row[kState] == kCounted + kTouched;
  }

  void count_contact(double *row, int panel) const {
    row[kLast] = panel;
    row[kFirst + panel] += 1.0;
  }

  void find_line(const SurfacePath &surface) {
    double farthest = -HUGE_VAL;
    for (size_t k = 0; k < u_.size(); ++k) {
      const Vec3 point = surface.position(line_.points[k]);
      u_[k] = farthest = std::max(farthest, dot(point, line_.along));  // where it folds, the upper part counts
      z_[k] = point.z;
    }
    for (size_t k = 0; k + 1 < u_.size(); ++k) {
      const double over = u_[k + 1] - u_[k];
      cosine_[k] = over / std::max(std::hypot(over, z_[k + 1] - z_[k]), 1e-12);
    }
  }

  // The same formula as `locate` in orchestrator/case/deck/line.py.
  Place locate(Vec3 position_m) const {
    const double at = dot(position_m, line_.along);
    const long points = static_cast<long>(u_.size());
    const long found = std::lower_bound(u_.begin(), u_.end(), at) - u_.begin() - 1;
    const long k = std::clamp(found, 0L, points - 2);
    const double over = u_[k + 1] - u_[k], climb = z_[k + 1] - z_[k];
    const double share = std::clamp((at - u_[k]) / std::max(over, 1e-12), 0.0, 1.0);
    const double station = line_.station_m[k] + share * (line_.station_m[k + 1] - line_.station_m[k]);
    const double across = dot(position_m, line_.across);
    const int panel = line_.panel[k];
    const double *open = &line_.open_m[4 * panel];
    return {panel, (position_m.z - z_[k] - share * climb) * cosine_[k], at >= u_.front() && at <= u_.back(),
            station >= open[0] && station <= open[1] && across >= open[2] && across <= open[3]};
  }

  DeckLine line_;
  int width_ = 0;
  std::vector<double> rows_;   // of all particles, one after the other
  std::vector<double> u_, z_, cosine_;  // of the line's points and the pieces behind them, now
};

}  // namespace flipflow
