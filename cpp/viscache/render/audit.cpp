#include "viscache/render/audit.h"

#include "viscache/render/pixel_audit.h"
#include "viscache/render/query_audit.h"

namespace viscache {

std::unique_ptr<TileAudit> make_audit(const FrameSettings& frame, const RayCaster& caster, float extent,
                                      const Control& control) {
    if (frame.audit_pixels > 0) return std::make_unique<PixelAudit>(frame, caster, extent, control);
    if (frame.audit_share > 0) return std::make_unique<QueryAudit>(frame, caster, extent, control);
    return nullptr;
}

}  // namespace viscache
