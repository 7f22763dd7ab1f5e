// Half of a ball of radius 10 mm, y >= 0, that touches the plane z = 0 at the origin [m].
//   gmsh -3 -format msh41 oblique_ball.geo -o oblique_ball.msh
// Tetrahedra with edges of 0.12 mm out to `touching`, farther away growing by `growth` per length up to 1.5 mm.
// `-setnumber refinement 2` halves every edge. The cap, 0.4 rad, is the surface that may touch.
SetFactory("OpenCASCADE");
DefineConstant[ refinement = 1 ];
radius = 0.010; cap = radius * (1 - Cos(0.4)); touching = 0.0006; growth = 0.3;
fine = 0.12e-3 / refinement; coarse = 1.5e-3 / refinement;

Sphere(1) = {0, 0, radius, radius, -Pi / 2, Pi / 2, Pi};
Box(2) = {-radius, 0, 0, 2 * radius, radius, cap};
below() = BooleanIntersection{ Volume{1}; }{ Volume{2}; };
above() = BooleanDifference{ Volume{1}; Delete; }{ Volume{2}; Delete; };
Coherence;

e = 1e-6;
Physical Volume("ball") = Volume{:};
Physical Surface("cap") = {5};
Physical Surface("middle") = Surface In BoundingBox{-radius - e, -e, -e, radius + e, e, 2 * radius + e};  // y = 0

Field[1] = MathEval;
Field[1].F = Sprintf("Min(%g, %g + %g * Max(Sqrt(x^2 + y^2 + z^2) - %g, 0))", coarse, fine, growth, touching);
Background Field = 1;
Mesh.Algorithm = 6;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
