#include <boost/math/distributions/students_t.hpp>

#include "worker/evaluate/statistics.h"

namespace parallax {

double StudentQuantile(double probability, double degrees) {
  return boost::math::quantile(boost::math::students_t(degrees), probability);
}

}  // namespace parallax
