#pragma once

/// \file
/// Comments only: the names of the physics, and where its formulas come from.
///
/// Frames. W world (`odom` on the wire, z up), R the URDF's root link (x forward, y left, z up), B the moving base (axes of R,
/// origin in the base's centre of mass), L a link, E an ellipsoid's own axes, C a contact point, O the base's origin seen as a
/// point of W, cm a centre of mass.
///
/// Quantities. p_AB position of B from A [m], X_AB pose, q_AB and R_AB rotation, v_AB velocity [m/s], w_AB angular velocity
/// [rad/s], f force [N], nhat unit normal; a last _E is the frame the numbers are in, left out when it is the first frame.
/// Letters that do not cancel are a bug.
///
/// Signs. nhat_W (u) points from the terrain into the vehicle; depth (delta) > 0 is overlap; v_n = nhat . v > 0 separates. A
/// triangle's front is the side from which its corners run counter-clockwise; only the front pushes.
///
/// Units are SI and radians everywhere, numbers are double.
///
/// Contact symbols: k stiffness [N/m], c damping [N s/m], mu friction coefficient [-], k_t and c_t tangential stiffness and
/// damping, l length of the tread's brush [m], tau its relaxation time [s], z tangential stretch [m], sigma slack [m], zeta
/// damping ratio [-], omega natural frequency [rad/s], h = omega dt [-] or half width h(u) [m] where it has an argument.
///
/// Sources, by key:
///   [CarPhysics]         the design brief "Car Physics": a car as a compound of ellipsoids, the world as sided triangles, the
///                        deepest triangle as a damped spring with friction, RK4 instead of Euler.
///   [ContactDefinition]  docs/physics.md, "Contact": rules 1 face, edge, vertex; 2 centre in front; 3 face; 4 local minima;
///                        5 deepest wins; 6 admission, depth and slack; 7 valley.
///   [BounceClosedForm]   docs/physics.md, "Bounce": the half oscillation of x'' + 2 zeta omega x' + omega^2 x = 0 up to the
///                        moment at which the spring would begin to pull.
///   [OscillatorErrors]   docs/physics.md, "Steps": what each integrator makes of the undamped oscillator.
///   [TorqueFreeBody]     L. D. Landau, E. M. Lifshitz, Mechanics, sec. 37: the asymmetrical top in elliptic functions.
///   [SlidingToRolling], [SlopeClosedForm], [StoppingDistance]   docs/physics.md, "Closed forms".
///   [BicycleModel]       [Pacejka2012] 1.3: steady cornering of the linear single-track vehicle.
///   [OscillatorLimits]   docs/physics.md, "Steps": spectral radius of each one-step map on the damped oscillator.
///   [Featherstone2008]   R. Featherstone, Rigid Body Dynamics Algorithms, Springer 2008: ch. 7 articulated bodies, 9.4 floating base.
///   [MuntheKaas1999]     H. Munthe-Kaas, High order Runge-Kutta methods on manifolds, Appl. Numer. Math. 29 (1999).
///   [Iserles2000]        A. Iserles et al., Lie-group methods, Acta Numerica 9 (2000), app. B.
///   [Pacejka2012]        H. Pacejka, Tire and Vehicle Dynamics, 3rd ed., 2012: 1.2 cornering stiffness, ch. 3 brush model.
///   [WongChiang2001]     J. Y. Wong, C. F. Chiang, A general theory for skid steering of tracked vehicles on firm ground,
///                        Proc. IMechE D 215 (2001): the turn at which shear forces and their moments balance.
///   [Stribeck1902]       R. Stribeck, Die wesentlichen Eigenschaften der Gleit- und Rollenlager, VDI-Z. 46 (1902).
///   [CanudasDeWit1995]   C. Canudas de Wit et al., A new model for control of systems with friction, IEEE TAC 40 (1995).
///   [FowlerNollVo]       G. Fowler, L. C. Noll, K.-P. Vo: the FNV-1a hash.
///   [Steele2014]         G. Steele, D. Lea, C. Flood, Fast splittable pseudorandom number generators, OOPSLA 2014: SplitMix64.
///   [Hamilton2006]       C. Hamilton, Compact Hilbert Indices, technical report CS-2006-07, Dalhousie University 2006.
///   [HilbertRTree]       I. Kamel, C. Faloutsos, On packing R-trees, CIKM 1993: leaves filled along a Hilbert curve.
///   [Hairer1993]         E. Hairer, S. Norsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed.: Runge-Kutta methods.
///   [HairerWanner1996]   E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, 2nd ed.: stiff problems, IV.9 linearly
///                        implicit methods.
///   [Barnes1999]         M. R. Barnes, Form finding and analysis of tension structures by dynamic relaxation, Int. J. Space
///                        Structures 14 (1999): kinetic damping.
///   [Schneider2014]      R. Schneider, Convex Bodies: The Brunn-Minkowski Theory, 2nd ed., Cambridge 2014: 3.2 summands, rolling.
///   [Nocedal2006]        J. Nocedal, S. Wright, Numerical Optimization, 2nd ed., Springer 2006: 3.1 sufficient decrease.
