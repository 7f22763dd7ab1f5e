// Two cylinders end on, axisymmetric: x is r, y is z [m]. Fine where they touch, squares of 0.5 mm far from there.
//   gmsh -2 -format msh41 rounded_striker.geo -o rounded_striker.msh
// Elements of 18 um on the face out to `touching`, farther away growing by `growth` per length up to 0.5 mm; recombined
// quadrilaterals to the depth `graded`, transfinite beyond it. `-setnumber refinement 2` halves every element.
// Nodes of both faces pair up because their lines have the same lengths and divisions.
DefineConstant[ refinement = 1 ];
radius = 0.005; length = 0.080; graded = 0.005;
fine = 18e-6 / refinement; coarse = 0.5e-3 / refinement; touching = 0.0016; growth = 0.2;

Mesh.Algorithm = 6;
Mesh.RecombineAll = 1;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;

// Each body has points of its own on the face: they share no node.
For body In {0 : 1}
  p = 100 * body;
  side = 2 * body - 1;  // the striker lies below, the target above
  Point(p + 1) = {0, 0, 0};              Point(p + 2) = {touching, 0, 0};  Point(p + 3) = {radius, 0, 0};
  Point(p + 4) = {0, side * graded, 0};  Point(p + 5) = {radius, side * graded, 0};
  Point(p + 6) = {0, side * length, 0};  Point(p + 7) = {radius, side * length, 0};
  Line(p + 1) = {p + 1, p + 2};  Line(p + 2) = {p + 2, p + 3};
  Line(p + 3) = {p + 1, p + 4};  Line(p + 4) = {p + 3, p + 5};  Line(p + 5) = {p + 4, p + 5};
  Line(p + 6) = {p + 4, p + 6};  Line(p + 7) = {p + 5, p + 7};  Line(p + 8) = {p + 6, p + 7};
  Curve Loop(p + 1) = {p + 1, p + 2, p + 4, -(p + 5), -(p + 3)};  Plane Surface(p + 1) = {p + 1};
  Curve Loop(p + 2) = {p + 5, p + 7, -(p + 8), -(p + 6)};         Plane Surface(p + 2) = {p + 2};
  Transfinite Curve {p + 5, p + 8} = Round(radius / coarse) + 1;
  Transfinite Curve {p + 6, p + 7} = Round((length - graded) / coarse) + 1;
  Transfinite Surface {p + 2};
EndFor

Field[1] = MathEval;
Field[1].F = Sprintf("Min(%g, %g + %g * Sqrt(Max(x - %g, 0)^2 + y^2))", coarse, fine, growth, touching);
Background Field = 1;

Physical Surface("steel") = {1, 2};
Physical Surface("carbide") = {101, 102};
Physical Curve("steel_face") = {1, 2};
Physical Curve("carbide_face") = {101, 102};
