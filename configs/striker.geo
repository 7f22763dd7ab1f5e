// A striker with a tapered back on a wider anvil, axisymmetric: x is r, y is z [m].
//   gmsh -2 -format msh41 striker.geo -o striker.msh
// Quadrilaterals throughout (transfinite, recombined), graded towards the contact. Nodes of both faces pair up because
// their lines have the same radius and division.
radius = 0.005; tail = 0.004; anvil_radius = 0.010;
tip = 0.004; length = 0.020; depth = 0.004; thickness = 0.016;
across = 8; tip_layers = 10; back_layers = 18; flange = 6;

Point(1) = {0, -length, 0};  Point(2) = {tail, -length, 0};
Point(3) = {0, -tip, 0};     Point(4) = {radius, -tip, 0};
Point(5) = {0, 0, 0};        Point(6) = {radius, 0, 0};
Line(1) = {1, 2};  Line(2) = {3, 4};  Line(3) = {5, 6};
Line(4) = {1, 3};  Line(5) = {2, 4};  Line(6) = {3, 5};  Line(7) = {4, 6};
Curve Loop(1) = {2, 7, -3, -6};  Plane Surface(1) = {1};  // tip
Curve Loop(2) = {1, 5, -2, -4};  Plane Surface(2) = {2};  // back

// The anvil has points of its own on the face: two bodies share no node.
Point(11) = {0, 0, 0};          Point(12) = {radius, 0, 0};          Point(13) = {anvil_radius, 0, 0};
Point(14) = {0, depth, 0};      Point(15) = {radius, depth, 0};      Point(16) = {anvil_radius, depth, 0};
Point(17) = {0, thickness, 0};  Point(18) = {radius, thickness, 0};  Point(19) = {anvil_radius, thickness, 0};
Line(11) = {11, 12};  Line(12) = {12, 13};  Line(13) = {14, 15};  Line(14) = {15, 16};
Line(15) = {17, 18};  Line(16) = {18, 19};
Line(17) = {11, 14};  Line(18) = {12, 15};  Line(19) = {13, 16};
Line(20) = {14, 17};  Line(21) = {15, 18};  Line(22) = {16, 19};
Curve Loop(11) = {11, 18, -13, -17};  Plane Surface(11) = {11};
Curve Loop(12) = {12, 19, -14, -18};  Plane Surface(12) = {12};
Curve Loop(13) = {13, 21, -15, -20};  Plane Surface(13) = {13};
Curve Loop(14) = {14, 22, -16, -21};  Plane Surface(14) = {14};

Transfinite Curve {1, 2, 3, 11, 13, 15} = across + 1;
Transfinite Curve {12, 14, 16} = flange + 1 Using Progression 1.15;
Transfinite Curve {6, 7} = tip_layers + 1 Using Progression 1 / 1.08;
Transfinite Curve {4, 5} = back_layers + 1 Using Progression 1 / 1.05;
Transfinite Curve {17, 18, 19} = tip_layers + 1 Using Progression 1.08;
Transfinite Curve {20, 21, 22} = back_layers + 1 Using Progression 1.03;
Transfinite Surface {1, 2, 11, 12, 13, 14};
Recombine Surface {1, 2, 11, 12, 13, 14};

Physical Surface("striker") = {1, 2};
Physical Surface("striker_tip") = {1};
Physical Surface("anvil") = {11, 12, 13, 14};
Physical Surface("anvil_tip") = {11, 12};
Physical Curve("striker_face") = {3};
Physical Curve("striker_back") = {1};
Physical Curve("anvil_face") = {11};
Physical Curve("anvil_base") = {15, 16};
