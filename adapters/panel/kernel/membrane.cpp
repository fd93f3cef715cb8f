#include "membrane.h"

#include <algorithm>

#include "biquadratic.h"
#include "membrane_law.h"

namespace flipflow {

namespace {

// Slopes of the position at the points of a group's cells, per cell length and width.
struct Slopes {
  Lanes along[3][9], across[3][9];
};

FLIPFLOW_INLINE void gather(const CellGroup &group, int nodes_across, const double *position_m,
                            Slopes &x) {
  for (int c = 0; c < 3; ++c) {
    Lanes node[9];
    for (int k = 0; k < 9; ++k)
      for (int lane = 0; lane < kLanes; ++lane)
        node[k][lane] =
            position_m[3 * (group.corner[lane] + k / 3 * nodes_across + k % 3) + c];
    slopes(node, x.along[c], x.across[c]);
  }
}

FLIPFLOW_INLINE void scatter(const CellGroup &group, int nodes_across, const Slopes &push,
                             double *force_N) {
  for (int c = 0; c < 3; ++c) {
    Lanes node[9];
    onto_nodes(push.along[c], push.across[c], node);
    for (int k = 0; k < 9; ++k)
      for (int lane = 0; lane < kLanes; ++lane)
        force_N[3 * (group.corner[lane] + k / 3 * nodes_across + k % 3) + c] += node[k][lane];
  }
}

FLIPFLOW_INLINE Symmetric metric(const CellGroup &group, const Slopes &x, int point) {
  Lanes ss{}, sy{}, yy{};
  for (int c = 0; c < 3; ++c) {
    const Lanes s = x.along[c][point], y = x.across[c][point];
    ss += s * s;
    sy += s * y;
    yy += y * y;
  }
  return {group.per_s2 * ss, group.per_y2 * yy, group.per_sy * sy};
}

// The branches' overstress at a point, as a stress that works on E; carries strain and stress.
FLIPFLOW_INLINE Symmetric overstress(const CellGroup &group, const Symmetric &C, Lanes weight,
                                     const Branches &branches, double *strain, double *stress,
                                     LaneSum *cross_J, Lanes &square_J) {
  const Lanes e11 = 0.5 * (C.a11 - 1.0), e22 = 0.5 * (C.a22 - 1.0);
  const Lanes now[3] = {group.strain[0] * e11 + group.strain[1] * e22,
                        group.strain[2] * e11 + group.strain[3] * e22, group.strain[4] * C.a12};
  Lanes change[3], over[3] = {};
  for (int k = 0; k < 3; ++k) {
    change[k] = now[k] - load(strain + k * kLanes);
    store(strain + k * kLanes, now[k]);
    square_J += weight * change[k] * change[k];
  }
  for (int b = 0; b < branches.count(); ++b, stress += 3 * kLanes) {
    const double ratio = branches.ratio()[b], decay = branches.decay()[b];
    const double gain = branches.gain()[b];
    Lanes cross{};
    for (int k = 0; k < 3; ++k) {
      const Lanes old = load(stress + k * kLanes), next = decay * old + gain * change[k];
      cross += old * change[k];
      over[k] += ratio * next;
      store(stress + k * kLanes, next);
    }
    cross_J[b].value += weight * cross;
  }
  return {group.strain[0] * over[0] + group.strain[2] * over[1],
          group.strain[1] * over[0] + group.strain[3] * over[1], group.strain[4] * over[2]};
}

template <bool perforated>
FLIPFLOW_INLINE Symmetric elastic_stress(const CellGroup &group, double c10_N_m, double c01_N_m,
                                         const Symmetric &C) {
  Symmetric S = solid_stress(c10_N_m, c01_N_m, C);
  if (perforated) {
    const Symmetric more = rest_stress(group.rest, C);
    S = {group.solid * S.a11 + more.a11, group.solid * S.a22 + more.a22,
         group.solid * S.a12 + more.a12};
  }
  return S;
}

struct Pass {
  const CellGroup *group;
  int groups, nodes_across;
  double c10_N_m, c01_N_m;
};

template <bool perforated>
FLIPFLOW_INLINE void step_all(const Pass &pass, const Branches &branches, const double *position_m,
                              double *strain, double *stress, double *force_N, LaneSum *cross_J,
                              Lanes &square_J) {
  for (int g = 0; g < pass.groups; ++g) {
    const CellGroup &group = pass.group[g];
    Slopes x;
    gather(group, pass.nodes_across, position_m, x);
    for (int point = 0; point < 9; ++point) {
      const Lanes weight = kWeight[point / 3] * kWeight[point % 3] * group.area;
      const Symmetric C = metric(group, x, point);
      Symmetric S = elastic_stress<perforated>(group, pass.c10_N_m, pass.c01_N_m, C);
      if (branches.count() > 0) {
        const Symmetric over =
            overstress(group, C, weight, branches, strain, stress, cross_J, square_J);
        S = {S.a11 + over.a11, S.a22 + over.a22, S.a12 + over.a12};
        strain += 3 * kLanes;
        stress += 3 * kLanes * branches.count();
      }
      S = {weight * group.per_s2 * S.a11, weight * group.per_y2 * S.a22,
           weight * group.per_sy * S.a12};
      for (int c = 0; c < 3; ++c) {
        const Lanes s = x.along[c][point], y = x.across[c][point];
        x.along[c][point] = s * S.a11 + y * S.a12;
        x.across[c][point] = s * S.a12 + y * S.a22;
      }
    }
    scatter(group, pass.nodes_across, x, force_N);
  }
}

FLIPFLOW_CLONES
void step_solid(const Pass &pass, const Branches &branches, const double *position_m,
                double *strain, double *stress, double *force_N, LaneSum *cross_J, Lanes &square_J) {
  step_all<false>(pass, branches, position_m, strain, stress, force_N, cross_J, square_J);
}

FLIPFLOW_CLONES
void step_perforated(const Pass &pass, const Branches &branches, const double *position_m,
                     double *strain, double *stress, double *force_N, LaneSum *cross_J,
                     Lanes &square_J) {
  step_all<true>(pass, branches, position_m, strain, stress, force_N, cross_J, square_J);
}

}  // namespace

Membrane::Membrane(const CellGrid &grid, const MembraneLaw &law)
    : groups_((grid.cells() + kLanes - 1) / kLanes),
      c10_N_m_(law.c10_N_m),
      c01_N_m_(law.c01_N_m),
      nodes_across_(grid.nodes_across()),
      perforated_(!law.rest.empty()) {
  const int across = static_cast<int>(grid.across_m.size());
  for (int n = 0; n < groups() * kLanes; ++n) {
    const int cell = std::min(n, grid.cells() - 1), lane = n % kLanes;
    const double s = grid.along_m[cell / across], y = grid.across_m[cell % across];
    CellGroup &group = groups_[n / kLanes];
    group.per_s2[lane] = 1.0 / (s * s);
    group.per_sy[lane] = 1.0 / (s * y);
    group.per_y2[lane] = 1.0 / (y * y);
    group.area[lane] = n < grid.cells() ? s * y : 0.0;
    group.corner[lane] = 2 * (cell / across) * nodes_across_ + 2 * (cell % across);
    for (int k = 0; k < 5; ++k) group.strain[k][lane] = law.strain[5 * cell + k];
    group.solid[lane] = law.solid[cell];
    for (int k = 0; k < 6; ++k) group.rest[k][lane] = perforated_ ? law.rest[6 * cell + k] : 0.0;
  }
}

StepWork Membrane::step(const Branches &branches, const double *position_m, double *strain,
                        double *stress, double *force_N) const {
  const Pass pass = {groups_.data(), groups(), nodes_across_, c10_N_m_, c01_N_m_};
  std::vector<LaneSum> cross_J(branches.count());
  Lanes square_J{};
  (perforated_ ? step_perforated : step_solid)(pass, branches, position_m, strain, stress, force_N,
                                               cross_J.data(), square_J);
  StepWork work(branches.count());
  std::transform(cross_J.begin(), cross_J.end(), work.cross_J.begin(),
                 [](const LaneSum &lanes) { return sum(lanes.value); });
  work.square_J = sum(square_J);
  return work;
}

double Membrane::energy_J(const double *position_m) const {
  Lanes total{};
  for (const CellGroup &group : groups_) {
    Slopes x;
    gather(group, nodes_across_, position_m, x);
    for (int point = 0; point < 9; ++point) {
      const Symmetric C = metric(group, x, point);
      Lanes density = group.solid * solid_energy(c10_N_m_, c01_N_m_, C);
      if (perforated_) density += rest_energy(group.rest, C);
      total += kWeight[point / 3] * kWeight[point % 3] * group.area * density;
    }
  }
  return sum(total);
}

}  // namespace flipflow
