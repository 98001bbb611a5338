; Detection of functions that hide a narrow force, with @@names@@ filled in by watch.py
;
; %row is a quadrature of an argument u: its coefficients are c[m] = u[m - 1] / m.

; The argument %x into the step (%k = 1), or its slope (%k = 2).
define internal double @argument(ptr noalias %row, double %x, i64 %k) #0 {
entry:
  %isslope = icmp eq i64 %k, 2
  br label %loop
loop:
  %m = phi i64 [ @@top@@, %entry ], [ %lower, %loop ]
  %sum = phi double [ 0.0, %entry ], [ %summed, %loop ]
  %place = mul i64 %m, @@width@@
  %ca = getelementptr inbounds double, ptr %row, i64 %place
  %c = load double, ptr %ca, align 8
  %number = uitofp i64 %m to double
  %u = fmul double %c, %number
  %lower = sub i64 %m, 1
  %power = uitofp i64 %lower to double
  %slope = fmul double %u, %power
  %term = select i1 %isslope, double %slope, double %u
  %summed = call double @llvm.fmuladd.f64(double %sum, double %x, double %term)
  %more = icmp uge i64 %lower, %k
  br i1 %more, label %loop, label %done
done:
  ret double %summed
}

; A bound of the change of the argument within a step of %h, from its terms up to %highest.
define internal double @wandering(ptr noalias %row, double %h, i64 %highest) #0 {
entry:
  br label %loop
loop:
  %m = phi i64 [ %highest, %entry ], [ %lower, %loop ]
  %sum = phi double [ 0.0, %entry ], [ %summed, %loop ]
  %place = mul i64 %m, @@width@@
  %ca = getelementptr inbounds double, ptr %row, i64 %place
  %c = load double, ptr %ca, align 8
  %number = uitofp i64 %m to double
  %c0 = call double @llvm.fabs.f64(double %c)
  %u = fmul double %c0, %number
  %added = fadd double %sum, %u
  %summed = fmul double %added, %h
  %lower = sub i64 %m, 1
  %more = icmp uge i64 %lower, 2
  br i1 %more, label %loop, label %done
done:
  ret double %summed
}

; The zero of the argument (or of its slope: see %k of @argument) between %x and %x + %part, where its signs differ.
define internal double @crossing(ptr noalias %row, double %x, double %part, i64 %k) #0 {
entry:
  %first = call double @argument(ptr %row, double %x, i64 %k)
  %begins = fcmp olt double %first, 0.0
  br label %loop
loop:
  %i = phi i64 [ 0, %entry ], [ %next, %loop ]
  %from = phi double [ %x, %entry ], [ %from1, %loop ]
  %piece = phi double [ %part, %entry ], [ %half, %loop ]
  %half = fmul double %piece, 0.5
  %middle = fadd double %from, %half
  %u = call double @argument(ptr %row, double %middle, i64 %k)
  %is = fcmp olt double %u, 0.0
  %same = icmp eq i1 %is, %begins
  %from1 = select i1 %same, double %middle, double %from
  %next = add nuw nsw i64 %i, 1
  %more = icmp ult i64 %next, @@bisections@@
  br i1 %more, label %loop, label %done
done:
  %root = fadd double %from1, %half
  ret double %root
}

; The place of an extremum of the argument within %part before and after %x, or %x if there is none.
define internal double @turning(ptr noalias %row, double %x, double %part, double %h) #0 {
entry:
  %down = fsub double %x, %part
  %up = fadd double %x, %part
  %from = call double @llvm.maxnum.f64(double %down, double 0.0)
  %to = call double @llvm.minnum.f64(double %up, double %h)
  %before = call double @argument(ptr %row, double %from, i64 2)
  %after = call double @argument(ptr %row, double %to, i64 2)
  %falls = fcmp olt double %before, 0.0
  %fell = fcmp olt double %after, 0.0
  %turns = icmp ne i1 %falls, %fell
  br i1 %turns, label %search, label %nowhere
search:
  %length = fsub double %to, %from
  %there = call double @crossing(ptr %row, double %from, double %length, i64 2)
  ret double %there
nowhere:
  ret double %x
}

; The series at the state that the step's own series gives at %x; returns whether the mass matrix is regular there.
define internal i1 @expand_at(ptr noalias %constants, double %t, ptr noalias %state, ptr noalias %work, ptr noalias %trial, double %x) #0 {
entry:
  %there = getelementptr inbounds double, ptr %trial, i64 @@at_series@@
  call void @clear(ptr %trial, i64 @@slot_2@@)
  call void @clear(ptr %there, i64 @@work_size@@)
  br label %row
row:
  %i = phi i64 [ 0, %entry ], [ %i_next, %summed ]
  %coefficients = getelementptr inbounds double, ptr %work, i64 %i
  br label %term
term:
  %m = phi i64 [ @@order@@, %row ], [ %lower, %term ]
  %sum = phi double [ 0.0, %row ], [ %sum_next, %term ]
  %place = mul i64 %m, @@width@@
  %ca = getelementptr inbounds double, ptr %coefficients, i64 %place
  %c = load double, ptr %ca, align 8
  %added = fadd double %sum, %c
  %sum_next = fmul double %added, %x
  %lower = sub i64 %m, 1
  %more = icmp uge i64 %lower, 1
  br i1 %more, label %term, label %summed
summed:
  %ya = getelementptr inbounds double, ptr %state, i64 %i
  %y = load double, ptr %ya, align 8
  %y_there = fadd double %y, %sum_next
  %sa = getelementptr inbounds double, ptr %trial, i64 %i
  store double %y_there, ptr %sa, align 8
  %i_next = add nuw nsw i64 %i, 1
  %more_rows = icmp ult i64 %i_next, @@rows@@
  br i1 %more_rows, label %row, label %expand
expand:
  %t_there = fadd double %t, %x
  %regular = call i1 @jet(ptr %constants, double %t_there, ptr %trial, ptr %there)
  ret i1 %regular
}

; How strongly the function shows at %x, from the computed argument: the larger it is, or the nearer to 0, the more.
define internal double @shown(ptr noalias %constants, double %t, ptr noalias %state, ptr noalias %work, ptr noalias %trial, i64 %which, double %x, i1 %greatest) #0 {
entry:
  %regular = call i1 @expand_at(ptr %constants, double %t, ptr %state, ptr %work, ptr %trial, double %x)
  %slot = add i64 %which, @@at_first@@
  %ua = getelementptr inbounds double, ptr %trial, i64 %slot
  %u = load double, ptr %ua, align 8
  %size = call double @llvm.fabs.f64(double %u)
  %nearness = fneg double %size
  %value = select i1 %greatest, double %u, double %nearness
  ret double %value
}

; The place within %length after %low where it shows most, by golden-section search.
define internal double @most_shown(ptr noalias %constants, double %t, ptr noalias %state, ptr noalias %work, ptr noalias %trial, i64 %which, double %low, double %length, i1 %greatest) #0 {
entry:
  %less = fmul double %length, @@minor@@
  %more_of = fmul double %length, @@major@@
  %x1_0 = fadd double %low, %less
  %x2_0 = fadd double %low, %more_of
  %f1_0 = call double @shown(ptr %constants, double %t, ptr %state, ptr %work, ptr %trial, i64 %which, double %x1_0, i1 %greatest)
  %f2_0 = call double @shown(ptr %constants, double %t, ptr %state, ptr %work, ptr %trial, i64 %which, double %x2_0, i1 %greatest)
  br label %loop
loop:
  %i = phi i64 [ 0, %entry ], [ %next, %loop ]
  %a = phi double [ %low, %entry ], [ %a_next, %loop ]
  %wide = phi double [ %length, %entry ], [ %wide_next, %loop ]
  %x1 = phi double [ %x1_0, %entry ], [ %x1_next, %loop ]
  %x2 = phi double [ %x2_0, %entry ], [ %x2_next, %loop ]
  %f1 = phi double [ %f1_0, %entry ], [ %f1_next, %loop ]
  %f2 = phi double [ %f2_0, %entry ], [ %f2_next, %loop ]
  %left = fcmp ogt double %f1, %f2
  %a_next = select i1 %left, double %a, double %x1
  %wide_next = fmul double %wide, @@major@@
  %portion = select i1 %left, double @@minor@@, double @@major@@
  %along = fmul double %wide_next, %portion
  %new = fadd double %a_next, %along
  %f = call double @shown(ptr %constants, double %t, ptr %state, ptr %work, ptr %trial, i64 %which, double %new, i1 %greatest)
  %x1_next = select i1 %left, double %new, double %x2
  %x2_next = select i1 %left, double %x1, double %new
  %f1_next = select i1 %left, double %f, double %f2
  %f2_next = select i1 %left, double %f1, double %f
  %next = add nuw nsw i64 %i, 1
  %more = icmp ult i64 %next, @@sections@@
  br i1 %more, label %loop, label %done
done:
  %better = fcmp ogt double %f1_next, %f2_next
  %place = select i1 %better, double %x1_next, double %x2_next
  ret double %place
}

; A place near the one where %which shows most at which the accelerations differ from the series, or 0.
define internal double @hidden_there(ptr noalias %constants, double %t, ptr noalias %state, ptr noalias %work, ptr noalias %trial, i64 %which, double %h, i1 %greatest) #0 {
entry:
  %part = fmul double %h, @@part@@
  br label %grid
grid:
  %k = phi i64 [ 0, %entry ], [ %k_next, %grid ]
  %most = phi double [ 0xFFF0000000000000, %entry ], [ %most_next, %grid ]
  %at = phi i64 [ 0, %entry ], [ %at_next, %grid ]
  %number = uitofp i64 %k to double
  %x = fmul double %part, %number
  %f = call double @shown(ptr %constants, double %t, ptr %state, ptr %work, ptr %trial, i64 %which, double %x, i1 %greatest)
  %is_more = fcmp ogt double %f, %most
  %most_next = select i1 %is_more, double %f, double %most
  %at_next = select i1 %is_more, i64 %k, i64 %at
  %k_next = add nuw nsw i64 %k, 1
  %more = icmp ule i64 %k_next, @@parts@@
  br i1 %more, label %grid, label %narrow
narrow:
  %place = uitofp i64 %at_next to double
  %middle = fmul double %part, %place
  %down = fsub double %middle, %part
  %up = fadd double %middle, %part
  %from = call double @llvm.maxnum.f64(double %down, double 0.0)
  %to = call double @llvm.minnum.f64(double %up, double %h)
  %length = fsub double %to, %from
  %there = call double @most_shown(ptr %constants, double %t, ptr %state, ptr %work, ptr %trial, i64 %which, double %from, double %length, i1 %greatest)
  br label %nearer
nearer:
  %i = phi i64 [ 0, %narrow ], [ %next, %on ]
  %whole = phi double [ %there, %narrow ], [ %back, %on ]
  %back = fmul double %whole, 0.5
  %earlier = fsub double %there, %back
  %new = call i1 @unseen(ptr %constants, double %t, ptr %state, ptr %work, ptr %trial, double %earlier, double %h)
  br i1 %new, label %found, label %on
on:
  %next = add nuw nsw i64 %i, 1
  %again = icmp ule i64 %next, @@bisections@@
  br i1 %again, label %nearer, label %none
none:
  ret double 0.0
found:
  ret double %there
}

; Whether the rates of velocities and quadratures at %x in a step of %h differ from those that its series predicts. (nan differs,
; too.)
define internal i1 @unseen(ptr noalias %constants, double %t, ptr noalias %state, ptr noalias %work, ptr noalias %trial, double %x, double %h) #0 {
entry:
  %there = getelementptr inbounds double, ptr %trial, i64 @@at_series@@
  %regular = call i1 @expand_at(ptr %constants, double %t, ptr %state, ptr %work, ptr %trial, double %x)
  %inverse = fdiv double @@seen@@, %h
  %longer = call double @llvm.maxnum.f64(double %h, double 1.0)
  %squared = fmul double %h, %longer
  %nothing = fdiv double @@nothing_much@@, %squared
  br i1 %regular, label %velocity, label %other
velocity:
  %j = phi i64 [ @@degrees@@, %entry ], [ %j_next, %rated ]
  %series = getelementptr inbounds double, ptr %work, i64 %j
  br label %rate
rate:
  %n = phi i64 [ @@top@@, %velocity ], [ %n_lower, %rate ]
  %r = phi double [ 0.0, %velocity ], [ %r_next, %rate ]
  %n_place = mul i64 %n, @@width@@
  %na = getelementptr inbounds double, ptr %series, i64 %n_place
  %cn = load double, ptr %na, align 8
  %number = uitofp i64 %n to double
  %weighted = fmul double %cn, %number
  %r_next = call double @llvm.fmuladd.f64(double %r, double %x, double %weighted)
  %n_lower = sub i64 %n, 1
  %n_more = icmp uge i64 %n_lower, 1
  br i1 %n_more, label %rate, label %rated
rated:
  %found_row = getelementptr inbounds double, ptr %there, i64 %j
  %found_at = getelementptr inbounds double, ptr %found_row, i64 @@width@@
  %found = load double, ptr %found_at, align 8
  %va = getelementptr inbounds double, ptr %state, i64 %j
  %v = load double, ptr %va, align 8
  %first_at = getelementptr inbounds double, ptr %series, i64 @@width@@
  %first = load double, ptr %first_at, align 8
  %difference = fsub double %found, %r_next
  %distance = call double @llvm.fabs.f64(double %difference)
  %v0 = call double @llvm.fabs.f64(double %v)
  %r0 = call double @llvm.fabs.f64(double %r_next)
  %f0 = call double @llvm.fabs.f64(double %first)
  %change = fadd double %r0, %f0
  %part = fmul double %change, @@seen@@
  %allowed0 = call double @llvm.fmuladd.f64(double %v0, double %inverse, double %part)
  %allowed = fadd double %allowed0, %nothing
  %apart = fcmp ugt double %distance, %allowed
  %j_after = add nuw nsw i64 %j, 1
  %last_velocity = icmp eq i64 %j_after, @@two_degrees@@
  %j_next = select i1 %last_velocity, i64 @@beyond@@, i64 %j_after
  %j_more = icmp ult i64 %j_next, @@rows@@
  %on0 = xor i1 %apart, true
  %on = and i1 %on0, %j_more
  br i1 %on, label %velocity, label %judged
judged:
  ret i1 %apart
other:
  ret i1 true
}

; The same at this place, or where the watched function is about 3 times smaller or larger: at its maximum a force may be 0.
; %power is 0 for an argument, or the absolute value of the exponent of a base.
define internal i1 @unseen_about(ptr noalias %constants, double %t, ptr noalias %state, ptr noalias %work, ptr noalias %trial, ptr noalias %row, double %x, double %h, double %power) #0 {
entry:
  %u = call double @argument(ptr %row, double %x, i64 1)
  %u0 = call double @llvm.fabs.f64(double %u)
  %isbase = fcmp ogt double %power, 0.0
  %part = fdiv double %u0, %power
  %enough = select i1 %isbase, double %part, double 1.0
  br label %nearer
nearer:
  %i = phi i64 [ 0, %entry ], [ %next, %nearer ]
  %whole = phi double [ %x, %entry ], [ %back, %nearer ]
  %back = fmul double %whole, 0.5
  %earlier = fsub double %x, %back
  %there = call double @argument(ptr %row, double %earlier, i64 1)
  %difference = fsub double %there, %u
  %change = call double @llvm.fabs.f64(double %difference)
  %isfar = fcmp ogt double %change, %enough
  %next = add nuw nsw i64 %i, 1
  %less = icmp ult i64 %next, @@bisections@@
  %more = and i1 %isfar, %less
  br i1 %more, label %nearer, label %look
look:
  %first = call i1 @unseen(ptr %constants, double %t, ptr %state, ptr %work, ptr %trial, double %earlier, double %h)
  br i1 %first, label %yes, label %again
again:
  %second = call i1 @unseen(ptr %constants, double %t, ptr %state, ptr %work, ptr %trial, double %x, double %h)
  ret i1 %second
yes:
  ret i1 true
}

; The place in a step of %h at which a watched function reveals a force that the series does not contain, or 0.
define internal double @hidden(ptr noalias %constants, double %t, ptr noalias %state, ptr noalias %work, ptr noalias %trial, i64 %which, double %h) #0 {
entry:
  %row = getelementptr inbounds double, ptr %work, i64 %which
  %number_of = sub i64 %which, @@first@@
  %powera = getelementptr inbounds double, ptr @watched_powers, i64 %number_of
  %signed = load double, ptr %powera, align 8
  %steep = fcmp olt double %signed, 0.0
  %power = call double @llvm.fabs.f64(double %signed)
  %growtha = getelementptr inbounds double, ptr @watched_growths, i64 %number_of
  %growth = load double, ptr %growtha, align 8
  %isbase = fcmp ogt double %power, 0.0
  %u0 = call double @argument(ptr %row, double 0.0, i64 1)
  %near0 = call double @llvm.fabs.f64(double %u0)
  %far = call double @wandering(ptr %row, double %h, i64 @@top@@)
  %powers = fmul double %far, %power
  %change = select i1 %isbase, double %powers, double %far
  %unit = select i1 %isbase, double %near0, double 1.0
  %close = fmul double %unit, @@close@@
  %wanders = fcmp ogt double %change, %close
  br i1 %wanders, label %known, label %nothing
nothing:
  ret double 0.0
; Its own series must have converged.
known:
  %without = call double @wandering(ptr %row, double %h, i64 @@all_but_two@@)
  %tail = fsub double %far, %without
  %reached = fadd double %near0, %far
  %part_of = fmul double %reached, @@base_tail@@
  %least_tail = select i1 %isbase, double %part_of, double @@tail@@
  %isknown = fcmp ole double %tail, %least_tail
  br i1 %isknown, label %search, label %unknown
unknown:
  ret double %h
search:
  %part = fmul double %h, @@part@@
  br label %grid
grid:
  %k = phi i64 [ 1, %search ], [ %k_next, %grid ]
  %before = phi double [ %u0, %search ], [ %u, %grid ]
  %most = phi double [ %u0, %search ], [ %most_next, %grid ]
  %at_most = phi i64 [ 0, %search ], [ %at_most_next, %grid ]
  %least = phi double [ %near0, %search ], [ %least_next, %grid ]
  %largest = phi double [ %near0, %search ], [ %largest_next, %grid ]
  %at_least = phi i64 [ 0, %search ], [ %at_least_next, %grid ]
  %at_cross = phi i64 [ 0, %search ], [ %at_cross_next, %grid ]
  %number = uitofp i64 %k to double
  %x = fmul double %part, %number
  %u = call double @argument(ptr %row, double %x, i64 1)
  %near = call double @llvm.fabs.f64(double %u)
  %is_most = fcmp ogt double %u, %most
  %most_next = select i1 %is_most, double %u, double %most
  %at_most_next = select i1 %is_most, i64 %k, i64 %at_most
  %is_least = fcmp olt double %near, %least
  %least_next = select i1 %is_least, double %near, double %least
  %at_least_next = select i1 %is_least, i64 %k, i64 %at_least
  %largest_next = call double @llvm.maxnum.f64(double %largest, double %near)
  %was = fcmp olt double %before, 0.0
  %is = fcmp olt double %u, 0.0
  %crosses = icmp ne i1 %was, %is
  %none_yet = icmp eq i64 %at_cross, 0
  %is_cross = and i1 %crosses, %none_yet
  %at_cross_next = select i1 %is_cross, i64 %k, i64 %at_cross
  %k_next = add nuw nsw i64 %k, 1
  %more = icmp ule i64 %k_next, @@parts@@
  br i1 %more, label %grid, label %measured
measured:
  %times = fmul double %least_next, %growth
  %moderate = fcmp olt double %largest_next, %times
  br i1 %moderate, label %nothing, label %sharpness
; If its series suffers cancellation, the argument is computed directly.
sharpness:
  %any_cross = icmp ne i64 %at_cross_next, 0
  %least_number = uitofp i64 %at_least_next to double
  %least_x = fmul double %part, %least_number
  %least_at = call double @turning(ptr %row, double %least_x, double %part, double %h)
  %u_least = call double @argument(ptr %row, double %least_at, i64 1)
  %near_least = call double @llvm.fabs.f64(double %u_least)
  %rounded = fmul double %reached, @@sharp@@
  %isnear = fcmp olt double %near_least, %rounded
  %cancels = or i1 %any_cross, %isnear
  %base_blurred = and i1 %steep, %cancels
  %argument_blurred = fcmp ogt double %rounded, @@argument_sharp@@
  %blurred = select i1 %isbase, i1 %base_blurred, i1 %argument_blurred
  br i1 %blurred, label %there, label %crossings
there:
  %nearest_there = call double @hidden_there(ptr %constants, double %t, ptr %state, ptr %work, ptr %trial, i64 %which, double %h, i1 false)
  %is_there = fcmp ogt double %nearest_there, 0.0
  %over = or i1 %is_there, %isbase
  br i1 %over, label %there_nearest, label %there_greatest
there_nearest:
  ret double %nearest_there
there_greatest:
  %greatest_there = call double @hidden_there(ptr %constants, double %t, ptr %state, ptr %work, ptr %trial, i64 %which, double %h, i1 true)
  ret double %greatest_there
crossings:
  br i1 %any_cross, label %cross, label %greatest
cross:
  %cross_before = sub i64 %at_cross_next, 1
  %cross_number = uitofp i64 %cross_before to double
  %cross_from = fmul double %part, %cross_number
  %cross_at = call double @crossing(ptr %row, double %cross_from, double %part, i64 1)
  %cross_new = call i1 @unseen_about(ptr %constants, double %t, ptr %state, ptr %work, ptr %trial, ptr %row, double %cross_at, double %h, double %power)
  br i1 %cross_new, label %found, label %greatest
greatest:
  %most_number = uitofp i64 %at_most_next to double
  %most_x = fmul double %part, %most_number
  %most_at = call double @turning(ptr %row, double %most_x, double %part, double %h)
  %any_most = fcmp ogt double %most_at, 0.0
  br i1 %any_most, label %at_greatest, label %nearest
at_greatest:
  %most_new = call i1 @unseen_about(ptr %constants, double %t, ptr %state, ptr %work, ptr %trial, ptr %row, double %most_at, double %h, double %power)
  br i1 %most_new, label %found, label %nearest
nearest:
  %other = icmp ne i64 %at_least_next, %at_most_next
  %turns = xor i1 %any_cross, true
  %distinct = and i1 %other, %turns
  br i1 %distinct, label %turn_least, label %nothing
turn_least:
  %any_least = fcmp ogt double %least_at, 0.0
  br i1 %any_least, label %at_nearest, label %nothing
at_nearest:
  %least_new = call i1 @unseen_about(ptr %constants, double %t, ptr %state, ptr %work, ptr %trial, ptr %row, double %least_at, double %h, double %power)
  br i1 %least_new, label %found, label %nothing
found:
  %where = phi double [ %cross_at, %cross ], [ %most_at, %at_greatest ], [ %least_at, %at_nearest ]
  ret double %where
}

; %h, or at most half the distance to a force that the series does not contain.
define internal double @watched(ptr noalias %constants, double %t, ptr noalias %state, ptr noalias %work, ptr noalias %trial, double %h) #0 {
entry:
  br label %again
again:
  %length = phi double [ %h, %entry ], [ %half, %shorten ]
  %tries = phi i64 [ 0, %entry ], [ %tried, %shorten ]
  br label %each
each:
  %which = phi i64 [ @@first@@, %again ], [ %next, %fine ]
  %where = call double @hidden(ptr %constants, double %t, ptr %state, ptr %work, ptr %trial, i64 %which, double %length)
  %clear = fcmp oeq double %where, 0.0
  br i1 %clear, label %fine, label %shorten
fine:
  %next = add nuw nsw i64 %which, 1
  %more = icmp ult i64 %next, @@beyond@@
  br i1 %more, label %each, label %done
shorten:
  %half = fmul double %where, 0.5
  %tried = add nuw nsw i64 %tries, 1
  %enough = icmp uge i64 %tried, @@tries@@
  br i1 %enough, label %done, label %again
done:
  %result = phi double [ %length, %fine ], [ %half, %shorten ]
  ret double %result
}
