#include "viscache/aqvc/parameters.h"

#include "viscache/aqvc/parameter_table.h"

namespace viscache {

void AqvcParameters::validate() const {
    for_each_parameter([this](const auto& row) { check_parameter(row, this->*row.member); });
}

}  // namespace viscache
