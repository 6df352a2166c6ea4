#pragma once

#include "clothsim/model/cloth_mesh.h"
#include "clothsim/model/cloth_spec.h"
#include "clothsim/model/triangle_fabric.h"

namespace clothsim {

/// Adds the bends of all triangles of a mesh to `fabric`, which has its triangles and edges; see
/// TriangleFabric. `edges`: of the mesh, by number. `materials`: by triangle.
void add_mesh_bends(const ClothMesh&, const std::vector<MeshEdge>& edges,
                    const std::vector<const Material*>& materials, TriangleFabric& fabric);

}  // namespace clothsim
