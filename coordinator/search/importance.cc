#include "coordinator/search/importance.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "common/base/rng.h"

namespace parallax {
namespace {

constexpr int kReplicates = 500;  // Bootstraps, and permutations.
constexpr double kTail = 0.025;
constexpr int kFewestMore = 3;  // Trials beyond the means' degrees of freedom.

// Returns the columns of the means that a field has: the first is 1, the second marks trials where
// it is not varied.
Eigen::MatrixXd DesignOf(const v1::SearchField& field, const std::vector<Outcome>& outcomes) {
  const auto rows = static_cast<Eigen::Index>(outcomes.size());
  const int groups = field.choices().empty() ? 3 : field.choices_size() + 1;
  Eigen::MatrixXd design = Eigen::MatrixXd::Zero(rows, groups + 1);
  design.col(0).setOnes();
  for (Eigen::Index i = 0; i < rows; ++i) {
    const std::string* value = ValueOf(outcomes[static_cast<size_t>(i)].values, field.path());
    if (value == nullptr) {
      design(i, 1) = 1;
    } else if (field.choices().empty()) {
      const double place = PlaceInRange(field, *value) - 0.5;
      design(i, 2) = place;
      design(i, 3) = place * place;
    } else {
      const auto choice = std::find(field.choices().begin(), field.choices().end(), *value);
      design(i, 2 + (choice - field.choices().begin()) % field.choices_size()) = 1;
    }
  }
  return design;
}

// Returns the variance of `y` that the columns leave; NaN if their means are as free as `y`,
// nearly.
double VarianceLeft(const Eigen::MatrixXd& design, const Eigen::VectorXd& y) {
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(design);
  const double free = static_cast<double>(design.rows() - qr.rank());
  if (free < kFewestMore) return std::nan("");
  return (y - design * qr.solve(y)).squaredNorm() / free;
}

// Returns the adjusted share of the variance of `y` that the field's values explain, beyond whether
// it is varied, which is the effect of other fields; negative where they explain less than chance
// does. NaN where nothing can be told.
double ShareOf(const Eigen::MatrixXd& design, const Eigen::VectorXd& y) {
  if (design.rows() <= kFewestMore) return std::nan("");
  const Eigen::VectorXd centred = y.array() - y.mean();
  const double all = centred.squaredNorm() / static_cast<double>(design.rows() - 1);
  if (!(all > 1e-20 * (1 + y.squaredNorm()))) return std::nan("");
  return (VarianceLeft(design.leftCols(2), centred) - VarianceLeft(design, centred)) / all;
}

double QuantileOf(std::vector<double> values, double quantile) {
  std::sort(values.begin(), values.end());
  return values[static_cast<size_t>(quantile * static_cast<double>(values.size() - 1))];
}

// Returns whether `share` exceeds the shares of 97.5 % of permutations of `y` among the trials
// where the field is varied: replicates draw trials twice, which many choices explain too well.
bool ExceedsChance(double share, const Eigen::MatrixXd& design, Eigen::VectorXd y, Rng& rng) {
  std::vector<Eigen::Index> varied;
  for (Eigen::Index i = 0; i < design.rows(); ++i) {
    if (design(i, 1) == 0) varied.push_back(i);
  }
  std::vector<double> shares;
  for (int permutation = 0; permutation < kReplicates; ++permutation) {
    for (size_t i = varied.size(); i-- > 1;) {
      std::swap(y(varied[i]),
                y(varied[static_cast<size_t>(rng.UniformInt(0, static_cast<int>(i)))]));
    }
    shares.push_back(ShareOf(design, y));
  }
  return share > QuantileOf(std::move(shares), 1 - kTail);
}

v1::SearchFigure IntervalOf(const Eigen::MatrixXd& design, const Eigen::VectorXd& y) {
  v1::SearchFigure figure;
  const double share = ShareOf(design, y);
  figure.set_high(1);
  if (std::isnan(share)) return figure;
  const int rows = static_cast<int>(y.size());
  Rng rng(SceneSeed{1}, "search/importance");
  std::vector<double> shares;
  Eigen::MatrixXd drawn_design(design.rows(), design.cols());
  Eigen::VectorXd drawn_y(y.size());
  for (int replicate = 0; replicate < kReplicates; ++replicate) {
    for (int i = 0; i < rows; ++i) {
      const int drawn = rng.UniformInt(0, rows - 1);
      drawn_design.row(i) = design.row(drawn);
      drawn_y(i) = y(drawn);
    }
    const double one = ShareOf(drawn_design, drawn_y);
    if (!std::isnan(one)) shares.push_back(std::clamp(one, 0.0, 1.0));
  }
  figure.set_value(std::clamp(share, 0.0, 1.0));
  figure.set_low(0);
  if (shares.size() < kReplicates / 2) return figure;
  figure.set_high(std::max(figure.value(), QuantileOf(shares, 1 - kTail)));
  const double low = std::min(figure.value(), QuantileOf(shares, kTail));
  if (low > 0 && ExceedsChance(share, design, y, rng)) figure.set_low(low);
  return figure;
}

}  // namespace

std::vector<v1::SearchImportance> ImportancesOf(const SearchSpace& space,
                                                const std::vector<Outcome>& outcomes) {
  Eigen::VectorXd y(static_cast<Eigen::Index>(outcomes.size()));
  for (size_t i = 0; i < outcomes.size(); ++i) {
    y(static_cast<Eigen::Index>(i)) = outcomes[i].objective;
  }
  std::vector<v1::SearchImportance> importances;
  for (const v1::SearchField& field : space) {
    v1::SearchImportance& importance = importances.emplace_back();
    importance.set_path(field.path());
    *importance.mutable_share() = IntervalOf(DesignOf(field, outcomes), y);
  }
  std::stable_sort(importances.begin(), importances.end(), [](const auto& a, const auto& b) {
    return a.share().value() > b.share().value();
  });
  return importances;
}

std::vector<Outcome> OutcomesOf(const v1::SearchRecord& record) {
  std::vector<Outcome> outcomes;
  for (const v1::SearchTrial& trial : record.trials()) {
    if (trial.number() == 0 || trial.scores().empty()) continue;
    outcomes.push_back({trial.values(), trial.scores(0).objective().value()});
  }
  return outcomes;
}

}  // namespace parallax
