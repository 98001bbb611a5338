; The stepping loop, with @@names@@ filled in by stepper.py
; The size of row %i over a step %h: the largest of its value and the next three terms of its series.
define internal double @size(ptr noalias %state, ptr noalias %row, i64 %i, double %h) #0 {
  %va = getelementptr inbounds double, ptr %state, i64 %i
  %v = load double, ptr %va, align 8
  %v0 = call double @llvm.fabs.f64(double %v)
  %aa = getelementptr inbounds double, ptr %row, i64 @@slot_1@@
  %a = load double, ptr %aa, align 8
  %a0 = call double @llvm.fabs.f64(double %a)
  %ba = getelementptr inbounds double, ptr %row, i64 @@slot_2@@
  %b = load double, ptr %ba, align 8
  %b0 = call double @llvm.fabs.f64(double %b)
  %da = getelementptr inbounds double, ptr %row, i64 @@slot_3@@
  %d = load double, ptr %da, align 8
  %d0 = call double @llvm.fabs.f64(double %d)
  %d1 = fmul double %d0, %h
  %bd = call double @llvm.maxnum.f64(double %b0, double %d1)
  %b1 = fmul double %bd, %h
  %ab = call double @llvm.maxnum.f64(double %a0, double %b1)
  %dv = fmul double %ab, %h
  %size = call double @llvm.maxnum.f64(double %v0, double %dv)
  ret double %size
}

; The ratio of %size to coefficient %c; infinite if either is 0.
define internal double @ratio(double %size, double %c) #0 {
  %c0 = call double @llvm.fabs.f64(double %c)
  %q = fdiv double %size, %c0
  %both = fmul double %size, %c0
  %isthere = fcmp ogt double %both, 0.0
  %ismoving = fcmp ogt double %size, @@rest@@
  %moves = and i1 %isthere, %ismoving
  %result = select i1 %moves, double %q, double 0x7FF0000000000000
  ret double %result
}

; The factor for a step if higher coefficients of the velocities have underflowed, so that only the lower ones limit it. It
; is 1 if most coefficients are there, or if the higher ones are 0 for another reason.
define internal double @faded(ptr noalias %work) #0 {
entry:
  br label %order
order:
  %m = phi i64 [ @@top@@, %entry ], [ %lower, %none ]
  %base = mul i64 %m, @@width@@
  br label %row
row:
  %i = phi i64 [ @@degrees@@, %order ], [ %next, %row ]
  %sum = phi double [ 0.0, %order ], [ %added, %row ]
  %place = add i64 %base, %i
  %ca = getelementptr inbounds double, ptr %work, i64 %place
  %c = load double, ptr %ca, align 8
  %c0 = call double @llvm.fabs.f64(double %c)
  %added = fadd double %sum, %c0
  %next = add nuw nsw i64 %i, 1
  %more = icmp ult i64 %next, @@two_degrees@@
  br i1 %more, label %row, label %judge
judge:
  %isthere = fcmp one double %added, 0.0
  br i1 %isthere, label %found, label %none
none:
  %lower = sub i64 %m, 1
  %goes_on = icmp ugt i64 %lower, 1
  br i1 %goes_on, label %order, label %found
found:
  %number = sitofp i64 %m to double
  %inverse = fdiv double 1.0, %number
  %exponent = fsub double %inverse, @@inverse_top@@
  %less = call double @llvm.pow.f64(double @@last_term@@, double %exponent)
  %isfaint = fcmp olt double %added, @@faint@@
  %isfew = icmp ult i64 %m, @@most@@
  %counts = and i1 %isfaint, %isfew
  %result = select i1 %counts, double %less, double 1.0
  ret double %result
}

; The step size from the coefficients of the velocities; their sizes are measured over a step %h. %total becomes infinite or
; nan if a coefficient is.
;
; The root of a number is 2^(log2 / m): its logarithm is read off its bits (to 0.09), the power is an exponent and a parabola
; (to 0.3 percent). The step needs no more, and this gives the same bits on every machine.
define internal double @length(ptr noalias %state, ptr noalias %work, double %h, ptr %total) #0 {
entry:
@@splat_h@@
  %reach = fmul double %h, @@farther@@
@@splat_reach@@
  br label %loop
loop:
  %i = phi i64 [ 0, %entry ], [ %next, %loop ]
  %sum = phi @@vector@@ [ zeroinitializer, %entry ], [ %sum_next, %loop ]
@@greatest@@
  %row = getelementptr inbounds double, ptr %work, i64 %i
  %ya = getelementptr inbounds double, ptr %state, i64 %i
  %y = load @@vector@@, ptr %ya, align 8
  %y0 = call @@vector@@ @llvm.fabs.@@tag@@(@@vector@@ %y)
@@size@@
@@splat_i@@
  %velocity = add <@@lanes@@ x i64> %i_v, @@from_degrees@@
  %is_velocity = icmp ult <@@lanes@@ x i64> %velocity, @@all_degrees@@
  %is_moving = fcmp ogt @@vector@@ %size, @@at_rest@@
  %counts = and <@@lanes@@ x i1> %is_velocity, %is_moving
  %inverse0 = fdiv @@vector@@ @@ones@@, %size
  %inverse = select <@@lanes@@ x i1> %counts, @@vector@@ %inverse0, @@vector@@ zeroinitializer
@@compare@@
  %next = add nuw nsw i64 %i, @@lanes@@
  %more = icmp ult i64 %next, @@width@@
  br i1 %more, label %loop, label %done
done:
  %old = load double, ptr %total, align 8
  %new = call double @llvm.vector.reduce.fadd.@@tag@@(double %old, @@vector@@ %sum_next)
  store double %new, ptr %total, align 8
@@gather@@
  %bits = bitcast <8 x double> %greatest to <8 x i64>
  %above = lshr <8 x i64> %bits, <i64 32, i64 32, i64 32, i64 32, i64 32, i64 32, i64 32, i64 32>
  %upper = trunc <8 x i64> %above to <8 x i32>
  %number = sitofp <8 x i32> %upper to <8 x double>
  %roots0 = call <8 x double> @llvm.fmuladd.v8f64(<8 x double> %number, <8 x double> @@slopes@@, <8 x double> @@offsets@@)
  %isthere = fcmp ogt <8 x double> %greatest, zeroinitializer
  %roots = select <8 x i1> %isthere, <8 x double> %roots0, <8 x double> @@none@@
  %e = call nnan double @llvm.vector.reduce.fmax.v8f64(<8 x double> %roots)
  %minus = fneg double %e
  %low = call nnan double @llvm.maxnum.f64(double %minus, double -1000.0)
  %bounded = call nnan double @llvm.minnum.f64(double %low, double 1000.0)
  %floor = call double @llvm.floor.f64(double %bounded)
  %f = fsub double %bounded, %floor
  %q1 = call double @llvm.fmuladd.f64(double %f, double 0x3FD5205BC01A36E3, double 0x3FE54395810624DD)
  %q2 = call double @llvm.fmuladd.f64(double %f, double %q1, double 1.0)
  %integer = fptosi double %floor to i64
  %biased = add i64 %integer, 1023
  %power = shl i64 %biased, 52
  %scale = bitcast i64 %power to double
  %radius = fmul double %q2, %scale
  %step = fmul double %radius, @@safety@@
  %any = call nnan double @llvm.vector.reduce.fmax.v8f64(<8 x double> %greatest)
  %endless = fcmp oeq double %any, 0.0
  %result = select i1 %endless, double 0x7FF0000000000000, double %step
  %lowest = extractelement <8 x double> %greatest, i64 0
  %highest = extractelement <8 x double> %greatest, i64 7
  %begins = fcmp ogt double %lowest, 0.0
  %vanishes = fcmp oeq double %highest, 0.0
  %fades = and i1 %begins, %vanishes
  br i1 %fades, label %faint, label %plain
plain:
  ret double %result
faint:
  %less = call double @faded(ptr %work)
  %shorter = fmul double %result, %less
  ret double %shorter
}

; The smallest ratio of all velocities at one coefficient.
define internal double @least_ratio(ptr noalias %state, ptr noalias %work, double %h, i64 %slot) #0 {
entry:
  br label %loop
loop:
  %i = phi i64 [ @@degrees@@, %entry ], [ %next, %loop ]
  %least = phi double [ 0x7FF0000000000000, %entry ], [ %smaller, %loop ]
  %row = getelementptr inbounds double, ptr %work, i64 %i
  %size = call double @size(ptr %state, ptr %row, i64 %i, double %h)
  %ca = getelementptr inbounds double, ptr %row, i64 %slot
  %c = load double, ptr %ca, align 8
  %r = call double @ratio(double %size, double %c)
  %smaller = call double @llvm.minnum.f64(double %least, double %r)
  %next = add nuw nsw i64 %i, 1
  %more = icmp ult i64 %next, @@two_degrees@@
  br i1 %more, label %loop, label %done
done:
  ret double %smaller
}

; A step after a much shorter one, or the first step: it is bounded by every coefficient from the @@lowest@@th on, since the
; last two may vanish by chance or by symmetry.
define internal double @cautious(ptr noalias %state, ptr noalias %work, double %guess) #0 {
entry:
  br label %loop
loop:
  %m = phi i64 [ @@lowest@@, %entry ], [ %next, %loop ]
  %least = phi double [ 0x7FF0000000000000, %entry ], [ %smaller, %loop ]
  %slot = mul i64 %m, @@width@@
  %r = call double @least_ratio(ptr %state, ptr %work, double %guess, i64 %slot)
  %n = sitofp i64 %m to double
  %root = fdiv double 1.0, %n
  %h = call double @llvm.pow.f64(double %r, double %root)
  %smaller = call double @llvm.minnum.f64(double %least, double %h)
  %next = add nuw nsw i64 %m, 1
  %more = icmp ule i64 %next, @@top@@
  br i1 %more, label %loop, label %done
done:
  %result = fmul double %smaller, @@safety@@
  ret double %result
}

; Set to zero. (Infinities and nan would spread: the sums also contain unused coefficients, times 0.)
define internal void @clear(ptr noalias %place, i64 %count) #0 {
entry:
  br label %loop
loop:
  %i = phi i64 [ 0, %entry ], [ %next, %loop ]
  %at = getelementptr inbounds double, ptr %place, i64 %i
  store <8 x double> zeroinitializer, ptr %at, align 64
  %next = add nuw nsw i64 %i, 8
  %more = icmp ult i64 %next, %count
  br i1 %more, label %loop, label %done
done:
  ret void
}

; If the higher coefficients overflow close to a singularity: a step with the finite ones only; the others are set to 0. The
; result is 0 if fewer than @@fewest@@ are left.
define internal double @shortened(ptr noalias %state, ptr noalias %work, double %guess) #0 {
entry:
  br label %order
order:
  %m = phi i64 [ 1, %entry ], [ %higher, %good ]
  %base = mul i64 %m, @@width@@
  br label %row
row:
  %i = phi i64 [ 0, %order ], [ %next, %row ]
  %sum = phi double [ 0.0, %order ], [ %added, %row ]
  %place = add i64 %base, %i
  %ca = getelementptr inbounds double, ptr %work, i64 %place
  %c = load double, ptr %ca, align 8
  %c0 = call double @llvm.fabs.f64(double %c)
  %added = fadd double %sum, %c0
  %next = add nuw nsw i64 %i, 1
  %more = icmp ult i64 %next, @@two_degrees@@
  br i1 %more, label %row, label %judge
judge:
  %finite = fcmp olt double %added, 0x7FF0000000000000
  br i1 %finite, label %good, label %cut
good:
  %higher = add nuw nsw i64 %m, 1
  %goes_on = icmp ule i64 %higher, @@order@@
  br i1 %goes_on, label %order, label %cut
cut:
  %end = phi i64 [ %m, %judge ], [ %higher, %good ]
  %enough = icmp ugt i64 %end, @@fewest@@
  br i1 %enough, label %above, label %hopeless
above:
  %k = phi i64 [ %end, %cut ], [ %k_next, %zeroed ]
  %is_above = icmp ule i64 %k, @@order@@
  br i1 %is_above, label %zeros, label %step
zeros:
  %k_base = mul i64 %k, @@width@@
  br label %zero
zero:
  %j = phi i64 [ 0, %zeros ], [ %j_next, %zero_next ]
  %j_place = add i64 %k_base, %j
  %j_at = getelementptr inbounds double, ptr %work, i64 %j_place
  store double 0.0, ptr %j_at, align 8
  br label %zero_next
zero_next:
  %j_next = add nuw nsw i64 %j, 1
  %j_more = icmp ult i64 %j_next, @@width@@
  br i1 %j_more, label %zero, label %zeroed
zeroed:
  %k_next = add nuw nsw i64 %k, 1
  br label %above
step:
  %long = call double @cautious(ptr %state, ptr %work, double %guess)
  %last = sub i64 %end, 2
  %number = sitofp i64 %last to double
  %inverse = fdiv double 1.0, %number
  %exponent = fsub double %inverse, @@inverse_top@@
  %less = call double @llvm.pow.f64(double @@last_term@@, double %exponent)
  %result = fmul double %long, %less
  ret double %result
hopeless:
  ret double 0.0
}

; Whether the accelerations at the end of a step, from the series that begins there, agree with those predicted by the step's
; own series; %allowed is the largest difference allowed.
define internal i1 @foretold(ptr noalias %work, ptr noalias %rates, ptr noalias %allowed, double %uneven, i1 %lax, double %room, double %slack) #0 {
entry:
@@splat_slack@@
@@splat_room@@
@@splat_uneven@@
  br label %loop
loop:
  %i = phi i64 [ 0, %entry ], [ %next, %loop ]
  %bad = phi <@@lanes@@ x i1> [ zeroinitializer, %entry ], [ %bad_next, %loop ]
  %row = getelementptr inbounds double, ptr %work, i64 %i
  %aa = getelementptr inbounds double, ptr %row, i64 @@slot_1@@
  %a = load @@vector@@, ptr %aa, align 8
  %ra = getelementptr inbounds double, ptr %rates, i64 %i
  %r = load @@vector@@, ptr %ra, align 8
  %la = getelementptr inbounds double, ptr %allowed, i64 %i
  %l = load @@vector@@, ptr %la, align 8
  %difference = fsub @@vector@@ %r, %a
  %distance = call @@vector@@ @llvm.fabs.@@tag@@(@@vector@@ %difference)
  %most = fadd @@vector@@ %l, %uneven_v
  %loosely = fmul @@vector@@ %most, %slack_v
  %strictly = fcmp ugt @@vector@@ %distance, %loosely
  %a0 = call @@vector@@ @llvm.fabs.@@tag@@(@@vector@@ %a)
  %r0 = call @@vector@@ @llvm.fabs.@@tag@@(@@vector@@ %r)
  %greater = call @@vector@@ @llvm.maxnum.@@tag@@(@@vector@@ %r0, @@vector@@ %a0)
  %grossly = fcmp ugt @@vector@@ %greater, %room_v
  %apart = select i1 %lax, <@@lanes@@ x i1> %grossly, <@@lanes@@ x i1> %strictly
@@splat_i@@
  %velocity = add <@@lanes@@ x i64> %i_v, @@from_degrees@@
  %is_velocity = icmp ult <@@lanes@@ x i64> %velocity, @@all_degrees@@
  %wrong = and <@@lanes@@ x i1> %apart, %is_velocity
  %bad_next = or <@@lanes@@ x i1> %bad, %wrong
  %next = add nuw nsw i64 %i, @@lanes@@
  %more = icmp ult i64 %next, @@width@@
  br i1 %more, label %loop, label %done
done:
  %any = call i1 @llvm.vector.reduce.or.v@@lanes@@i1(<@@lanes@@ x i1> %bad_next)
  %all = xor i1 %any, true
  ret i1 %all
}

; 0 times the sum of the accelerations: nan if one is not finite.
define internal double @accelerations(ptr noalias %work) #0 {
entry:
  %row = getelementptr inbounds double, ptr %work, i64 @@slot_1@@
  br label %loop
loop:
  %i = phi i64 [ @@degrees@@, %entry ], [ %next, %loop ]
  %sum = phi double [ 0.0, %entry ], [ %added, %loop ]
  %aa = getelementptr inbounds double, ptr %row, i64 %i
  %a = load double, ptr %aa, align 8
  %none = fmul double %a, 0.0
  %added = fadd double %sum, %none
  %next = add nuw nsw i64 %i, 1
  %more = icmp ult i64 %next, @@two_degrees@@
  br i1 %more, label %loop, label %done
done:
  ret double %added
}

; %to = %from, whole states
define internal void @copy(ptr noalias %from, ptr noalias %to) #0 {
entry:
  br label %loop
loop:
  %i = phi i64 [ 0, %entry ], [ %next, %loop ]
  %fa = getelementptr inbounds double, ptr %from, i64 %i
  %x = load <@@lanes@@ x double>, ptr %fa, align 8
  %ta = getelementptr inbounds double, ptr %to, i64 %i
  store <@@lanes@@ x double> %x, ptr %ta, align 8
  %next = add nuw nsw i64 %i, @@lanes@@
  %more = icmp ult i64 %next, @@clock_end@@
  br i1 %more, label %loop, label %done
done:
  ret void
}

define i64 @advance(ptr noalias %constants, ptr noalias %state, ptr noalias %work, ptr noalias %trial, double %stop, ptr noalias %times, i64 %count, ptr noalias %out, i64 %stride, i64 %last, i64 %pause, ptr noalias %info) #0 {
entry:
  %total = alloca double, align 8
  %begana = alloca i64, align 8
  %limita = alloca i64, align 8
  %limitb = alloca i64, align 8
  %lengtha = alloca double, align 8
  %unevena = alloca double, align 8
  %tpa = getelementptr inbounds double, ptr %state, i64 @@time@@
  %tla = getelementptr inbounds double, ptr %tpa, i64 1
  %hpa = getelementptr inbounds double, ptr %tpa, i64 2
  %gapa = getelementptr inbounds double, ptr %tpa, i64 3
  %pacea = getelementptr inbounds double, ptr %tpa, i64 4
  %milda = getelementptr inbounds double, ptr %tpa, i64 8
  %lasta = getelementptr inbounds double, ptr %tpa, i64 5
  %timesa = getelementptr inbounds double, ptr %tpa, i64 6
  %neara = getelementptr inbounds double, ptr %tpa, i64 7
  %refuseda = getelementptr inbounds double, ptr %tpa, i64 9
  %beyonda = getelementptr inbounds double, ptr %tpa, i64 10
  %laxa = getelementptr inbounds double, ptr %tpa, i64 11
  %pacen = getelementptr inbounds double, ptr %trial, i64 @@at_next@@
  %lastn = getelementptr inbounds double, ptr %pacen, i64 1
  %timesn = getelementptr inbounds double, ptr %pacen, i64 2
  %nearn = getelementptr inbounds double, ptr %pacen, i64 3
  %laxn = getelementptr inbounds double, ptr %pacen, i64 4
  %low = getelementptr inbounds double, ptr %state, i64 @@low@@
  %rates = getelementptr inbounds double, ptr %trial, i64 @@at_rates@@
  %allowed = getelementptr inbounds double, ptr %trial, i64 @@at_allowed@@
  %stepsa = getelementptr inbounds i64, ptr %info, i64 1
  %limitsa = getelementptr inbounds i64, ptr %info, i64 2
  store i64 0, ptr %limita, align 8
  call void @clear(ptr %work, i64 @@work_size@@)
  br label %step
step:
  %index = phi i64 [ 0, %entry ], [ %sampled, %advanced ], [ %sampled, %again ], [ %began, %again_from ]
  %taken = phi i64 [ 0, %entry ], [ %taken1, %advanced ], [ %taken1, %again ], [ %less, %again_from ]
  %pending = phi i64 [ @@nothing@@, %entry ], [ %pending1, %advanced ], [ %pending1, %again ], [ @@nothing@@, %again_from ]
  %t = load double, ptr %tpa, align 8
  %tl = load double, ptr %tla, align 8
  %hp = load double, ptr %hpa, align 8
  %tn = fadd double %t, %tl
  %regular = call i1 @jet(ptr %constants, double %tn, ptr %state, ptr %work)
  %unchecked = icmp eq i64 %pending, @@nothing@@
  br i1 %unchecked, label %checked, label %check
check:
  %stride_taken = load double, ptr %lengtha, align 8
  %squared = fmul double %stride_taken, %stride_taken
  %room = fdiv double @@nothing_much@@, %squared
  %mild_ones = load double, ptr %milda, align 8
  %isnoisy = fcmp oge double %mild_ones, @@evidence@@
  %slack = select i1 %isnoisy, double @@noisy@@, double 1.0
  %lax_taken = load double, ptr %laxa, align 8
  %islax = fcmp ogt double %lax_taken, 0.0
  %apart_by = load double, ptr %unevena, align 8
  %foretold = call i1 @foretold(ptr %work, ptr %rates, ptr %allowed, double %apart_by, i1 %islax, double %room, double %slack)
  %good = and i1 %foretold, %regular
  %isblind = icmp eq i64 %pending, @@blind@@
  br i1 %good, label %confirmed, label %refuse
; The prediction failed: there is a critical point within the step that the series does not show. Go back and take at most
; half the step; or, if the equations were singular just beyond the point, go twice as far beyond it. (If small differences
; recur, they are due to rounding, and the allowance is raised.)
refuse:
  %began = load i64, ptr %begana, align 8
  %less = sub i64 %taken, 1
  %toofar = load double, ptr %lengtha, align 8
  %usual_step = load double, ptr %pacen, align 8
  %much = fmul double %usual_step, 0x3EB0000000000000
  %isfar = fcmp ogt double %toofar, %much
  %hopeless = and i1 %isfar, %isblind
  br i1 %hopeless, label %wall, label %again_from
; The critical point cannot be passed. The run ends at the last state where the equations hold, or at the first one where
; they are not finite.
wall:
  %there = call double @accelerations(ptr %work)
  %number = fcmp ord double %there, 0.0
  %nonumber = xor i1 %number, true
  %outside = and i1 %nonumber, %regular
  br i1 %outside, label %return, label %inside
inside:
  call void @copy(ptr %trial, ptr %state)
  %cause = select i1 %regular, i64 @@underflow@@, i64 @@singular@@
  br label %return
again_from:
  %mild = call i1 @foretold(ptr %work, ptr %rates, ptr %allowed, double %apart_by, i1 %islax, double %room, double @@noisy@@)
  call void @copy(ptr %trial, ptr %state)
  call void @clear(ptr %work, i64 @@work_size@@)
  %twice = fmul double %toofar, 2.0
  %bound = select i1 %isblind, double %twice, double %toofar
  %gap_before = load double, ptr %gapa, align 8
  %begins = fcmp oeq double %gap_before, 0.0
  %refused_before = load double, ptr %refuseda, align 8
  %refused_on = select i1 %begins, double 1.0, double %refused_before
  %beyond_on = uitofp i1 %isblind to double
  %ismild0 = and i1 %mild, %begins
  %ismild1 = and i1 %ismild0, %regular
  %quarter_pace = fmul double %usual_step, 0.25
  %usually = fcmp ogt double %toofar, %quarter_pace
  %near_here = load double, ptr %neara, align 8
  %apart_from = fcmp oeq double %near_here, 0.0
  %undisturbed = and i1 %usually, %apart_from
  %ismild = and i1 %ismild1, %undisturbed
  %one_more = uitofp i1 %ismild to double
  %mild_now = fadd double %mild_ones, %one_more
  store double %mild_now, ptr %milda, align 8
  store double %bound, ptr %gapa, align 8
  store double %refused_on, ptr %refuseda, align 8
  store double %beyond_on, ptr %beyonda, align 8
  store double %lax_taken, ptr %laxa, align 8
  %pace_before = load double, ptr %pacea, align 8
  %pace_then = select i1 %begins, double %usual_step, double %pace_before
  store double %pace_then, ptr %pacea, align 8
  br label %step
confirmed:
  store double 0.0, ptr %refuseda, align 8
  store double 0.0, ptr %beyonda, align 8
  store double 0.0, ptr %laxa, align 8
  switch i64 %pending, label %checked [ i64 @@end@@, label %return
                                        i64 @@samples@@, label %many ]
; The step contains more samples than there is room for. It is completed after they are written, from the unchanged state.
many:
  call void @copy(ptr %trial, ptr %state)
  %limit_then = load i64, ptr %limitb, align 8
  store i64 %limit_then, ptr %limita, align 8
  %without = sub i64 %taken, 1
  br label %return
checked:
  %enough = icmp uge i64 %taken, %pause
  br i1 %enough, label %return, label %expanded
expanded:
  br i1 %regular, label %measure, label %return
measure:
  store double 0.0, ptr %total, align 8
  %isfirst = fcmp oeq double %hp, 0.0
  br i1 %isfirst, label %first, label %usual
first:
  %g0 = call double @length(ptr %state, ptr %work, double 1.0, ptr %total)
  %g1 = call double @llvm.minnum.f64(double %g0, double 0x4C63E9E4E4C2F344)
  %g2 = call double @length(ptr %state, ptr %work, double %g1, ptr %total)
  %g3 = call double @llvm.minnum.f64(double %g2, double 0x4C63E9E4E4C2F344)
  br label %careful
usual:
  %hu = call double @length(ptr %state, ptr %work, double %hp, ptr %total)
  %leap = fmul double %hp, 4.0
  %isleap = fcmp ogt double %hu, %leap
  br i1 %isleap, label %careful, label %chosen
careful:
  %guess = phi double [ %g3, %first ], [ %hp, %usual ]
  %hc = call double @cautious(ptr %state, ptr %work, double %guess)
  br label %chosen
chosen:
  %h0 = phi double [ %hu, %usual ], [ %hc, %careful ]
  %met = load double, ptr %total, align 8
  %finite = fcmp olt double %met, 0x7FF0000000000000
  br i1 %finite, label %long, label %rescue
rescue:
  %hr = call double @shortened(ptr %state, ptr %work, double %h0)
  %rescued = fcmp ogt double %hr, 0.0
  br i1 %rescued, label %long, label %return
long:
  %shown = phi double [ %h0, %chosen ], [ %hr, %rescue ]
  %ts = call double @llvm.fabs.f64(double %tn)
  %ulp = fmul double %ts, 0x3CC0000000000000
  %left = fsub double %stop, %tn
  %ahead = call double @llvm.minnum.f64(double %shown, double %left)
  %shortened = call double @detected(ptr %constants, double %tn, ptr %state, ptr %work, ptr %trial, double %ahead)
  %isless = fcmp olt double %shortened, %ahead
  %h = select i1 %isless, double %shortened, double %shown
  %reach = call double @llvm.minnum.f64(double %h, double %left)
  %finest = fmul double %ts, 0x3AF0000000000000
  %least = fadd double %finest, 0x0010000000000000
  %tiny = fcmp ole double %h, %least
  %short = fcmp olt double %h, %left
  %stuck = and i1 %tiny, %short
  br i1 %stuck, label %return, label %approach
; Before a critical point: halve the distance until it is at the resolution of doubles, then step to just beyond the point. If
; steps as short as that are not confirmed either, the differences are due to rounding.
approach:
  %gap = load double, ptr %gapa, align 8
  %keptpace = load double, ptr %pacea, align 8
  store double %keptpace, ptr %pacen, align 8
  %keptlast = load double, ptr %lasta, align 8
  store double %keptlast, ptr %lastn, align 8
  %kepttimes = load double, ptr %timesa, align 8
  store double %kepttimes, ptr %timesn, align 8
  %keptnear = load double, ptr %neara, align 8
  store double %keptnear, ptr %nearn, align 8
  %keptlax = load double, ptr %laxa, align 8
  store double %keptlax, ptr %laxn, align 8
  %nogap = fcmp oeq double %gap, 0.0
  br i1 %nogap, label %free, label %near
; The allowance is based on the usual step size (the pace). It shrinks no faster than the steps do in front of a singularity,
; and short steps just after a critical point do not reduce it.
free:
  %gap_kept = phi double [ %gap, %approach ], [ 0.0, %noisy ]
  %quarter_more = fmul double %hp, 1.25
  %grows = fcmp ogt double %h, %quarter_more
  %just = fcmp oge double %keptnear, 2.0
  %leaving0 = or i1 %grows, %just
  %isnear = fcmp ogt double %keptnear, 0.0
  %leaving = and i1 %leaving0, %isnear
  %lagging = fmul double %keptpace, @@lag@@
  %pacelag = call double @llvm.maxnum.f64(double %reach, double %lagging)
  %pacenew = select i1 %leaving, double %keptpace, double %pacelag
  %near_next = select i1 %leaving, double 1.0, double 0.0
  store double %pacenew, ptr %pacen, align 8
  store double %near_next, ptr %nearn, align 8
  br label %bounded
near:
  %half = fmul double %gap, 0.5
  %keptbeyond = load double, ptr %beyonda, align 8
  %beyond = fcmp ogt double %keptbeyond, 0.0
  %keptrefused = load double, ptr %refuseda, align 8
  %refused = fcmp ogt double %keptrefused, 0.0
  %grain = select i1 %refused, double 0x3E70000000000000, double 0x3C90000000000000
  %shorter = call double @llvm.minnum.f64(double %h, double %keptpace)
  %length = select i1 %refused, double %shorter, double %keptpace
  %fine = fmul double %length, %grain
  %resolved = fadd double %ulp, %fine
  %far = fcmp ogt double %half, %resolved
  %seen = fcmp ogt double %h, %resolved
  %apart0 = and i1 %far, %seen
  %notbeyond = xor i1 %beyond, true
  %apart = and i1 %apart0, %notbeyond
  %before = call double @llvm.minnum.f64(double %h, double %half)
  br i1 %apart, label %bounded, label %between
between:
  %doubtful = and i1 %refused, %notbeyond
  br i1 %doubtful, label %noisy, label %pass
noisy:
  %tried = fcmp ogt double %keptlax, 0.0
  store double 1.0, ptr %laxn, align 8
  br i1 %tried, label %return, label %free
; Passed many times while t hardly changes: the motion sticks at this point.
pass:
  %lastpass = load double, ptr %lasta, align 8
  %passes = load double, ptr %timesa, align 8
  %since = fsub double %tn, %lastpass
  %notime = fmul double %ts, 0x3DB0000000000000
  %atonce = fcmp ole double %since, %notime
  %passes1 = fadd double %passes, 1.0
  %passes2 = select i1 %atonce, double %passes1, double 0.0
  store double %tn, ptr %lastn, align 8
  store double %passes2, ptr %timesn, align 8
  %stays = fcmp oge double %passes2, @@passes@@
  br i1 %stays, label %return, label %straight
; This close to the point, the higher coefficients consist of rounding errors only.
straight:
  %twice_resolved = fmul double %resolved, 2.0
  %short_gap = call double @llvm.minnum.f64(double %gap, double %twice_resolved)
  %over = select i1 %beyond, double %gap, double %short_gap
  %higher = getelementptr inbounds double, ptr %work, i64 @@slot_4@@
  call void @clear(ptr %higher, i64 @@above_4@@)
  br label %bounded
bounded:
  %gap_now = phi double [ %gap_kept, %free ], [ %gap, %near ], [ %gap, %straight ]
  %hl = phi double [ %h, %free ], [ %before, %near ], [ %over, %straight ]
  %confirm = phi i1 [ true, %free ], [ true, %near ], [ false, %straight ]
; Whether the stop time may have influenced this step. As long as it has not, a run to a later time takes the same steps.
  %limit_before = load i64, ptr %limita, align 8
  store i64 %limit_before, ptr %limitb, align 8
  %looks_beyond = fcmp oge double %shown, %left
  %goes_beyond = fcmp oge double %hl, %left
  %is_limited = or i1 %looks_beyond, %goes_beyond
  %limited_now = zext i1 %is_limited to i64
  %limit_now = or i64 %limit_before, %limited_now
  store i64 %limit_now, ptr %limita, align 8
  br label %sampling
sampling:
  %at = phi i64 [ %index, %bounded ], [ %atn, %stored ]
  %sa = getelementptr inbounds double, ptr %times, i64 %at
  %s = load <8 x double>, ptr %sa, align 8
@@splat8_t@@
@@splat8_tl@@
@@splat8_hl@@
  %dt1 = fsub <8 x double> %s, %t_v
  %dt = fsub <8 x double> %dt1, %tl_v
  %within = fcmp ole <8 x double> %dt, %hl_v
  %mask = bitcast <8 x i1> %within to i8
  %ones = call i8 @llvm.ctpop.i8(i8 %mask)
  %hits = zext i8 %ones to i64
  %any = icmp ne i64 %hits, 0
  br i1 %any, label %dense, label %sampledall
dense:
  %di = phi i64 [ 0, %sampling ], [ %dnext, %dense ]
  %srow = getelementptr inbounds double, ptr %work, i64 %di
@@horner_vector@@
  %dya = getelementptr inbounds double, ptr %state, i64 %di
  %dy = load double, ptr %dya, align 8
  %dla = getelementptr inbounds double, ptr %low, i64 %di
  %dl = load double, ptr %dla, align 8
@@splat8_dy@@
@@splat8_dl@@
  %change = fadd <8 x double> %srow.poly, %dl_v
  %value = fadd <8 x double> %dy_v, %change
  %orow = mul i64 %di, %stride
  %oplace = add i64 %orow, %at
  %oa = getelementptr inbounds double, ptr %out, i64 %oplace
  store <8 x double> %value, ptr %oa, align 8
  %dnext = add nuw nsw i64 %di, 1
  %dmore = icmp ult i64 %dnext, @@rows@@
  br i1 %dmore, label %dense, label %stored
stored:
  %atn = add i64 %at, %hits
  %full = icmp eq i64 %hits, 8
  br i1 %full, label %sampling, label %sampledall
sampledall:
  %sampled = phi i64 [ %at, %sampling ], [ %atn, %stored ]
  %final = fcmp ole double %left, %hl
  %usedup = icmp uge i64 %sampled, %count
  %islast = icmp ne i64 %last, 0
  %ending0 = and i1 %usedup, %islast
  %ending = and i1 %ending0, %final
  %nomore = xor i1 %islast, true
  %leave = and i1 %usedup, %nomore
  %unseen = xor i1 %confirm, true
  %given = and i1 %leave, %unseen
  br i1 %given, label %return, label %move
move:
  call void @copy(ptr %state, ptr %trial)
  store i64 %index, ptr %begana, align 8
  %left1 = fsub double %stop, %t
  %left2 = fsub double %left1, %tl
  %hs = select i1 %final, double %left2, double %hl
  store double %hs, ptr %lengtha, align 8
  %pace = load double, ptr %pacen, align 8
  store double %pace, ptr %pacea, align 8
  %lastnext = load double, ptr %lastn, align 8
  store double %lastnext, ptr %lasta, align 8
  %timesnext = load double, ptr %timesn, align 8
  store double %timesnext, ptr %timesa, align 8
  %nearnext = load double, ptr %nearn, align 8
  %near_then = select i1 %confirm, double %nearnext, double 2.0
  store double %near_then, ptr %neara, align 8
  %laxnext = load double, ptr %laxn, align 8
  store double %laxnext, ptr %laxa, align 8
  %inverse_pace = fdiv double 1.0, %pace
  %noise = fmul double %ulp, %inverse_pace
  %almost0 = fadd double %noise, @@almost@@
  %almost = select i1 %confirm, double %almost0, double 0.0
@@splat_almost@@
  %passing = fdiv double @@almost@@, %hs
  %slow_noise = fmul double %inverse_pace, @@rounding@@
  %fast_noise = fdiv double @@resolution@@, %hs
  %speed_noise0 = fadd double %slow_noise, %fast_noise
  %speed_noise = select i1 %confirm, double %speed_noise0, double %passing
@@splat_speed_noise@@
  %longer = call double @llvm.maxnum.f64(double %hs, double 1.0)
  %hs2 = fmul double %hs, %longer
  %nothing0 = fdiv double @@nothing_much@@, %hs2
  %nothing = select i1 @@is_watching@@, double %nothing0, double 0.0
@@splat_nothing@@
  br label %update
update:
  %ui = phi i64 [ 0, %move ], [ %unext, %update ]
  %most = phi @@vector@@ [ zeroinitializer, %move ], [ %most_next, %update ]
  %row = getelementptr inbounds double, ptr %work, i64 %ui
@@splat_hs@@
@@horner_update@@
  %vi = add i64 %ui, @@degrees@@
  %vla = getelementptr inbounds double, ptr %low, i64 %vi
  %vl = load @@vector@@, ptr %vla, align 8
  %vlh = fmul @@vector@@ %vl, %hs_v
@@splat_ui@@
  %urows = add <@@lanes@@ x i64> %ui_v, @@counted@@
  %isq = icmp ult <@@lanes@@ x i64> %urows, @@all_degrees@@
  %extra = select <@@lanes@@ x i1> %isq, @@vector@@ %vlh, @@vector@@ zeroinitializer
  %uya = getelementptr inbounds double, ptr %state, i64 %ui
  %ula = getelementptr inbounds double, ptr %low, i64 %ui
  %uy = load @@vector@@, ptr %uya, align 8
  %ul = load @@vector@@, ptr %ula, align 8
  %rest0 = fadd @@vector@@ %ul, %extra
  %rest = fadd @@vector@@ %rest0, %row.rest
  %delta = fadd @@vector@@ %row.poly, %rest
  %sum = fadd @@vector@@ %uy, %delta
  %back = fsub @@vector@@ %sum, %uy
  %e1 = fsub @@vector@@ %sum, %back
  %e2 = fsub @@vector@@ %uy, %e1
  %e3 = fsub @@vector@@ %delta, %back
  %error = fadd @@vector@@ %e2, %e3
  store @@vector@@ %sum, ptr %uya, align 8
  store @@vector@@ %error, ptr %ula, align 8
@@rate@@
  %rate0 = call @@vector@@ @llvm.fabs.@@tag@@(@@vector@@ %rate)
  %slope0 = call @@vector@@ @llvm.fabs.@@tag@@(@@vector@@ %c1.c)
  %sum0 = call @@vector@@ @llvm.fabs.@@tag@@(@@vector@@ %sum)
  %uy0 = call @@vector@@ @llvm.fabs.@@tag@@(@@vector@@ %uy)
  %lesser = call nnan @@vector@@ @llvm.minnum.@@tag@@(@@vector@@ %sum0, @@vector@@ %uy0)
  %both = fadd @@vector@@ %rate0, %slope0
  %speed = fmul @@vector@@ %lesser, %speed_noise_v
  %close0 = call @@vector@@ @llvm.fmuladd.@@tag@@(@@vector@@ %both, @@vector@@ %almost_v, @@vector@@ %speed)
  %close = fadd @@vector@@ %close0, %nothing_v
  %ra = getelementptr inbounds double, ptr %rates, i64 %ui
  store @@vector@@ %rate, ptr %ra, align 8
  %la = getelementptr inbounds double, ptr %allowed, i64 %ui
  store @@vector@@ %close, ptr %la, align 8
  %place = select <@@lanes@@ x i1> %isq, @@vector@@ %lesser, @@vector@@ zeroinitializer
  %most_next = call nnan @@vector@@ @llvm.maxnum.@@tag@@(@@vector@@ %most, @@vector@@ %place)
  %unext = add nuw nsw i64 %ui, @@lanes@@
  %umore = icmp ult i64 %unext, @@width@@
  br i1 %umore, label %update, label %clock
clock:
  %th = fadd double %tl, %hs
  %tsum = fadd double %t, %th
  %tback = fsub double %tsum, %t
  %te1 = fsub double %tsum, %tback
  %te2 = fsub double %t, %te1
  %te3 = fsub double %th, %tback
  %terror = fadd double %te2, %te3
  store double %tsum, ptr %tpa, align 8
  store double %terror, ptr %tla, align 8
  %farthest = call nnan double @llvm.vector.reduce.fmax.@@tag@@(@@vector@@ %most_next)
  %per_time = fmul double %farthest, %inverse_pace
  %uneven0 = fmul double %per_time, %slow_noise
  %uneven = select i1 %confirm, double %uneven0, double 0.0
  store double %uneven, ptr %unevena, align 8
  store double %reach, ptr %hpa, align 8
  %isfree = fcmp oeq double %gap_now, 0.0
  %rest_gap0 = fsub double %gap_now, %hs
  %rest_gap1 = select i1 %isfree, double 0.0, double %rest_gap0
  %rest_gap = select i1 %confirm, double %rest_gap1, double 0.0
  store double %rest_gap, ptr %gapa, align 8
  %taken1 = add i64 %taken, 1
  %pending_on = select i1 %confirm, i64 @@moved@@, i64 @@blind@@
  %pending_leave = select i1 %leave, i64 @@samples@@, i64 %pending_on
  %pending1 = select i1 %ending, i64 @@end@@, i64 %pending_leave
  %blind_end = and i1 %ending, %unseen
  br i1 %blind_end, label %return, label %advanced
advanced:
  br i1 %finite, label %step, label %again
again:
  call void @clear(ptr %work, i64 @@work_size@@)
  br label %step
return:
  %code = phi i64 [ %pending, %confirmed ], [ @@samples@@, %many ], [ @@pause@@, %checked ], [ @@singular@@, %expanded ], [ @@not_finite@@, %wall ], [ %cause, %inside ], [ @@not_finite@@, %rescue ], [ @@underflow@@, %long ], [ @@underflow@@, %pass ], [ @@underflow@@, %noisy ], [ @@samples@@, %sampledall ], [ @@end@@, %clock ]
  %used = phi i64 [ %index, %confirmed ], [ %index, %many ], [ %index, %checked ], [ %index, %expanded ], [ %began, %wall ], [ %began, %inside ], [ %index, %rescue ], [ %index, %long ], [ %index, %pass ], [ %index, %noisy ], [ %sampled, %sampledall ], [ %sampled, %clock ]
  %steps = phi i64 [ %taken, %confirmed ], [ %without, %many ], [ %taken, %checked ], [ %taken, %expanded ], [ %less, %wall ], [ %less, %inside ], [ %taken, %rescue ], [ %taken, %long ], [ %taken, %pass ], [ %taken, %noisy ], [ %taken, %sampledall ], [ %taken1, %clock ]
  store i64 %used, ptr %info, align 8
  %limited = load i64, ptr %limita, align 8
  store i64 %limited, ptr %limitsa, align 8
  store i64 %steps, ptr %stepsa, align 8
  ret i64 %code
}
