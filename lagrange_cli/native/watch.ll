; Functions that hide a narrow force, with @@names@@ filled in by watch.py
;
; %row is a quadrature of an argument u: its coefficients are c[m] = u[m - 1] / m.

; The argument %x into the step: its value (%k = 1), its first (2) or its second derivative (3).
define internal double @argument(ptr noalias %row, double %x, i64 %k) #0 {
entry:
  br label %loop
loop:
  %m = phi i64 [ @@top@@, %entry ], [ %lower, %loop ]
  %sum = phi double [ 0.0, %entry ], [ %summed, %loop ]
  %place = mul i64 %m, @@width@@
  %ca = getelementptr inbounds double, ptr %row, i64 %place
  %c = load double, ptr %ca, align 8
  %number = uitofp i64 %m to double
  %u = fmul double %c, %number
  %less1 = sub i64 %m, 1
  %less2 = sub i64 %m, 2
  %one = uitofp i64 %less1 to double
  %two = uitofp i64 %less2 to double
  %both = fmul double %one, %two
  %slope = icmp eq i64 %k, 2
  %bend = icmp eq i64 %k, 3
  %w1 = select i1 %slope, double %one, double 1.0
  %w2 = select i1 %bend, double %both, double %w1
  %term = fmul double %u, %w2
  %summed = call double @llvm.fmuladd.f64(double %sum, double %x, double %term)
  %lower = sub i64 %m, 1
  %more = icmp uge i64 %lower, %k
  br i1 %more, label %loop, label %done
done:
  ret double %summed
}

; How far the argument may get from where it is, at most, within a step of %h, by its terms up to %highest.
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

; Where the argument is greatest or least about %x, a part %part of the step before and after it.
define internal double @turning(ptr noalias %row, double %x, double %part, double %h) #0 {
entry:
  %down = fsub double %x, %part
  %from = call double @llvm.maxnum.f64(double %down, double 0.0)
  %up = fadd double %x, %part
  %to = call double @llvm.minnum.f64(double %up, double %h)
  br label %loop
loop:
  %i = phi i64 [ 0, %entry ], [ %next, %loop ]
  %at = phi double [ %x, %entry ], [ %bounded, %loop ]
  %slope = call double @argument(ptr %row, double %at, i64 2)
  %bend = call double @argument(ptr %row, double %at, i64 3)
  %change = fdiv double %slope, %bend
  %there = fsub double %at, %change
  %above = call double @llvm.maxnum.f64(double %there, double %from)
  %bounded = call double @llvm.minnum.f64(double %above, double %to)
  %next = add nuw nsw i64 %i, 1
  %more = icmp ult i64 %next, @@refinements@@
  br i1 %more, label %loop, label %done
done:
  ret double %bounded
}

; Where between %x and %x + %part, at which it has different signs, the argument is 0.
define internal double @crossing(ptr noalias %row, double %x, double %part) #0 {
entry:
  %first = call double @argument(ptr %row, double %x, i64 1)
  %begins = fcmp olt double %first, 0.0
  br label %loop
loop:
  %i = phi i64 [ 0, %entry ], [ %next, %loop ]
  %from = phi double [ %x, %entry ], [ %from1, %loop ]
  %piece = phi double [ %part, %entry ], [ %half, %loop ]
  %half = fmul double %piece, 0.5
  %middle = fadd double %from, %half
  %u = call double @argument(ptr %row, double %middle, i64 1)
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

; Whether the accelerations %x into a step of %h are other than what its series foretells. (What is no number is, too.)
define internal i1 @unseen(ptr noalias %constants, double %t, ptr noalias %state, ptr noalias %work, ptr noalias %trial, double %x, double %h) #0 {
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
  %inverse = fdiv double @@seen@@, %h
  %longer = call double @llvm.maxnum.f64(double %h, double 1.0)
  %squared = fmul double %h, %longer
  %nothing = fdiv double @@nothing_much@@, %squared
  br i1 %regular, label %velocity, label %other
velocity:
  %j = phi i64 [ @@degrees@@, %expand ], [ %j_next, %rated ]
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
  %j_next = add nuw nsw i64 %j, 1
  %j_more = icmp ult i64 %j_next, @@two_degrees@@
  %on0 = xor i1 %apart, true
  %on = and i1 %on0, %j_more
  br i1 %on, label %velocity, label %judged
judged:
  ret i1 %apart
other:
  ret i1 true
}

; The same there, or where the argument is less or more by about 1: at its height a force may be 0.
define internal i1 @unseen_about(ptr noalias %constants, double %t, ptr noalias %state, ptr noalias %work, ptr noalias %trial, ptr noalias %row, double %x, double %h) #0 {
entry:
  %slope = call double @argument(ptr %row, double %x, i64 2)
  %bend2 = call double @argument(ptr %row, double %x, i64 3)
  %slope0 = call double @llvm.fabs.f64(double %slope)
  %bend0 = call double @llvm.fabs.f64(double %bend2)
  %bend = fmul double %bend0, 0.5
  %root = call double @llvm.sqrt.f64(double %bend)
  %rate = fadd double %slope0, %root
  %before = fdiv double 1.0, %rate
  %half = fmul double %x, 0.5
  %back = call double @llvm.minnum.f64(double %before, double %half)
  %earlier = fsub double %x, %back
  %first = call i1 @unseen(ptr %constants, double %t, ptr %state, ptr %work, ptr %trial, double %earlier, double %h)
  br i1 %first, label %yes, label %again
again:
  %second = call i1 @unseen(ptr %constants, double %t, ptr %state, ptr %work, ptr %trial, double %x, double %h)
  ret i1 %second
yes:
  ret i1 true
}

; Where one watched argument shows something that the series of a step of %h does not: how far into it, or 0.
define internal double @hidden(ptr noalias %constants, double %t, ptr noalias %state, ptr noalias %work, ptr noalias %trial, i64 %which, double %h) #0 {
entry:
  %row = getelementptr inbounds double, ptr %work, i64 %which
  %far = call double @wandering(ptr %row, double %h, i64 @@top@@)
  %wanders = fcmp ogt double %far, @@close@@
  br i1 %wanders, label %known, label %nothing
nothing:
  ret double 0.0
; Its own series must be true.
known:
  %without = call double @wandering(ptr %row, double %h, i64 @@all_but_two@@)
  %tail = fsub double %far, %without
  %isknown = fcmp ole double %tail, @@tail@@
  br i1 %isknown, label %search, label %unknown
unknown:
  ret double %h
search:
  %part = fmul double %h, @@part@@
  %u0 = call double @argument(ptr %row, double 0.0, i64 1)
  %near0 = call double @llvm.fabs.f64(double %u0)
  br label %grid
grid:
  %k = phi i64 [ 1, %search ], [ %k_next, %grid ]
  %before = phi double [ %u0, %search ], [ %u, %grid ]
  %most = phi double [ %u0, %search ], [ %most_next, %grid ]
  %at_most = phi i64 [ 0, %search ], [ %at_most_next, %grid ]
  %least = phi double [ %near0, %search ], [ %least_next, %grid ]
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
  %was = fcmp olt double %before, 0.0
  %is = fcmp olt double %u, 0.0
  %crosses = icmp ne i1 %was, %is
  %none_yet = icmp eq i64 %at_cross, 0
  %is_cross = and i1 %crosses, %none_yet
  %at_cross_next = select i1 %is_cross, i64 %k, i64 %at_cross
  %k_next = add nuw nsw i64 %k, 1
  %more = icmp ule i64 %k_next, @@parts@@
  br i1 %more, label %grid, label %crossings
crossings:
  %any_cross = icmp ne i64 %at_cross_next, 0
  br i1 %any_cross, label %cross, label %greatest
cross:
  %cross_before = sub i64 %at_cross_next, 1
  %cross_number = uitofp i64 %cross_before to double
  %cross_from = fmul double %part, %cross_number
  %cross_at = call double @crossing(ptr %row, double %cross_from, double %part)
  %cross_new = call i1 @unseen_about(ptr %constants, double %t, ptr %state, ptr %work, ptr %trial, ptr %row, double %cross_at, double %h)
  br i1 %cross_new, label %found, label %greatest
greatest:
  %most_number = uitofp i64 %at_most_next to double
  %most_x = fmul double %part, %most_number
  %most_at = call double @turning(ptr %row, double %most_x, double %part, double %h)
  %any_most = fcmp ogt double %most_at, 0.0
  br i1 %any_most, label %at_greatest, label %nearest
at_greatest:
  %most_new = call i1 @unseen_about(ptr %constants, double %t, ptr %state, ptr %work, ptr %trial, ptr %row, double %most_at, double %h)
  br i1 %most_new, label %found, label %nearest
nearest:
  %other = icmp ne i64 %at_least_next, %at_most_next
  %turns = xor i1 %any_cross, true
  %distinct = and i1 %other, %turns
  br i1 %distinct, label %turn_least, label %nothing
turn_least:
  %least_number = uitofp i64 %at_least_next to double
  %least_x = fmul double %part, %least_number
  %least_at = call double @turning(ptr %row, double %least_x, double %part, double %h)
  %any_least = fcmp ogt double %least_at, 0.0
  br i1 %any_least, label %at_nearest, label %nothing
at_nearest:
  %least_new = call i1 @unseen_about(ptr %constants, double %t, ptr %state, ptr %work, ptr %trial, ptr %row, double %least_at, double %h)
  br i1 %least_new, label %found, label %nothing
found:
  %where = phi double [ %cross_at, %cross ], [ %most_at, %at_greatest ], [ %least_at, %at_nearest ]
  ret double %where
}

; %h, or less: no further than half the way to what its series does not show.
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
