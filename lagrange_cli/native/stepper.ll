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

; How much smaller coefficient %c is than %size; infinite where either is 0.
define internal double @ratio(double %size, double %c) #0 {
  %c0 = call double @llvm.fabs.f64(double %c)
  %q = fdiv double %size, %c0
  %both = fmul double %size, %c0
  %moves = fcmp ogt double %both, 0.0
  %result = select i1 %moves, double %q, double 0x7FF0000000000000
  ret double %result
}

; The step from the coefficients of the velocities, whose sizes are measured over a step %h. %total becomes infinite or no
; number where a coefficient is.
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
  %is_moving = fcmp ogt @@vector@@ %size, zeroinitializer
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
  %roots = call <8 x double> @llvm.fmuladd.v8f64(<8 x double> %number, <8 x double> @@slopes@@, <8 x double> @@offsets@@)
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
  ret double %result
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

; a step that follows a much shorter one, or none: bounded by every coefficient from the @@lowest@@th on, since the
; last two may vanish by chance or symmetry
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

; Zeros. (What is not finite would stay: sums take in more coefficients than there are, times 0.)
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

; So near a singularity that the higher coefficients overflow: a step with the finite ones alone; the others are set to 0.
; The result is 0 if fewer than @@fewest@@ are left.
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

; whether the series, followed to the end of the step %h, still satisfies the equations there (up to what changes
; coordinates by 2^-45 of themselves: a coordinate in equilibrium has accelerations that are nothing but rounding)
define internal i1 @holds(ptr noalias %constants, ptr noalias %state, ptr noalias %work, double %h, ptr noalias %trial) #0 {
entry:
  %trial_work = getelementptr inbounds double, ptr %trial, i64 @@trial_offset@@
  call void @clear(ptr %trial, i64 @@trial_size@@)
  br label %rows
rows:
  %i = phi i64 [ 0, %entry ], [ %next, %rows ]
  %row = getelementptr inbounds double, ptr %work, i64 %i
@@horner@@
  %ya = getelementptr inbounds double, ptr %state, i64 %i
  %y = load double, ptr %ya, align 8
  %z = fadd double %y, %row.poly
  %za = getelementptr inbounds double, ptr %trial, i64 %i
  store double %z, ptr %za, align 8
  %next = add nuw nsw i64 %i, 1
  %more = icmp ult i64 %next, @@two_degrees@@
  br i1 %more, label %rows, label %evaluate
evaluate:
  %ta = getelementptr inbounds double, ptr %state, i64 @@time@@
  %t = load double, ptr %ta, align 8
  %te = fadd double %t, %h
  %regular = call i1 @jet(ptr %constants, double %te, ptr %trial, ptr %trial_work)
  br i1 %regular, label %compare, label %bad
compare:
  %j = phi i64 [ @@degrees@@, %evaluate ], [ %jn, %better ]
  %vrow = getelementptr inbounds double, ptr %work, i64 %j
@@horner_rate@@
  %jb1 = add i64 %j, @@slot_1@@
  %aa = getelementptr inbounds double, ptr %trial_work, i64 %jb1
  %a = load double, ptr %aa, align 8
  %difference = fsub double %rate, %a
  %distance = call double @llvm.fabs.f64(double %difference)
  %a0a = getelementptr inbounds double, ptr %vrow, i64 @@slot_1@@
  %a0 = load double, ptr %a0a, align 8
  %a0s = call double @llvm.fabs.f64(double %a0)
  %as = call double @llvm.fabs.f64(double %a)
  %both = fadd double %a0s, %as
  %va = getelementptr inbounds double, ptr %trial, i64 %j
  %v = load double, ptr %va, align 8
  %vs = call double @llvm.fabs.f64(double %v)
  %vh = fdiv double %vs, %h
  %size = fadd double %both, %vh
  %jq = sub i64 %j, @@degrees@@
  %qa = getelementptr inbounds double, ptr %trial, i64 %jq
  %q = load double, ptr %qa, align 8
  %qs = call double @llvm.fabs.f64(double %q)
  %qh = fdiv double %qs, %h
  %qhh = fdiv double %qh, %h
  %rounding = fmul double %qhh, 0x3D20000000000000
  %allowed = call double @llvm.fmuladd.f64(double %size, double 0x3EB0C6F7A0B5ED8D, double %rounding)
  %good = fcmp ole double %distance, %allowed
  br i1 %good, label %better, label %bad
better:
  %jn = add nuw nsw i64 %j, 1
  %jmore = icmp ult i64 %jn, @@two_degrees@@
  br i1 %jmore, label %compare, label %fine
fine:
  ret i1 true
bad:
  ret i1 false
}

define i64 @advance(ptr noalias %constants, ptr noalias %state, ptr noalias %work, ptr noalias %trial, double %stop, ptr noalias %times, i64 %count, ptr noalias %out, i64 %stride, i64 %last, i64 %pause, ptr noalias %info) #0 {
entry:
  %total = alloca double, align 8
  %tpa = getelementptr inbounds double, ptr %state, i64 @@time@@
  %tla = getelementptr inbounds double, ptr %tpa, i64 1
  %hpa = getelementptr inbounds double, ptr %tpa, i64 2
  %low = getelementptr inbounds double, ptr %state, i64 @@low@@
  %stepsa = getelementptr inbounds i64, ptr %info, i64 1
  br label %step
step:
  %index = phi i64 [ 0, %entry ], [ %sampled, %advanced ], [ %sampled, %again ]
  %taken = phi i64 [ 0, %entry ], [ %taken1, %advanced ], [ %taken1, %again ]
  %enough = icmp uge i64 %taken, %pause
  br i1 %enough, label %paused, label %expand
expand:
  %t = load double, ptr %tpa, align 8
  %tl = load double, ptr %tla, align 8
  %hp = load double, ptr %hpa, align 8
  %tn = fadd double %t, %tl
  %regular = call i1 @jet(ptr %constants, double %tn, ptr %state, ptr %work)
  br i1 %regular, label %measure, label %singular
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
  %left0 = fsub double %stop, %tn
  %hc0 = call double @cautious(ptr %state, ptr %work, double %guess)
  br label %vet
vet:
  %hc = phi double [ %hc0, %careful ], [ %shorter, %reject ]
  %tries = phi i64 [ 0, %careful ], [ %tries1, %reject ]
  %needed = call double @llvm.minnum.f64(double %hc, double %left0)
  %sound = call i1 @holds(ptr %constants, ptr %state, ptr %work, double %needed, ptr %trial)
  %tired = icmp ugt i64 %tries, 30
  %accept = or i1 %sound, %tired
  br i1 %accept, label %chosen, label %reject
reject:
  %shorter = fmul double %needed, 0.25
  %tries1 = add i64 %tries, 1
  br label %vet
chosen:
  %h0 = phi double [ %hu, %usual ], [ %hc, %vet ]
  %met = load double, ptr %total, align 8
  %finite = fcmp olt double %met, 0x7FF0000000000000
  br i1 %finite, label %long, label %rescue
rescue:
  %hr = call double @shortened(ptr %state, ptr %work, double %h0)
  %rescued = fcmp ogt double %hr, 0.0
  br i1 %rescued, label %long, label %notfinite
long:
  %h = phi double [ %h0, %chosen ], [ %hr, %rescue ]
  %ts = call double @llvm.fabs.f64(double %tn)
  %ulp = fmul double %ts, 0x3CC0000000000000
  %floor = fadd double %ulp, 0x0010000000000000
  %left = fsub double %stop, %tn
  %tiny = fcmp ole double %h, %floor
  %short = fcmp olt double %h, %left
  %stuck = and i1 %tiny, %short
  br i1 %stuck, label %stuckat, label %sampling
sampling:
  %at = phi i64 [ %index, %long ], [ %atn, %stored ]
  %sa = getelementptr inbounds double, ptr %times, i64 %at
  %s = load <8 x double>, ptr %sa, align 8
@@splat8_t@@
@@splat8_tl@@
@@splat8_h@@
  %dt1 = fsub <8 x double> %s, %t_v
  %dt = fsub <8 x double> %dt1, %tl_v
  %within = fcmp ole <8 x double> %dt, %h_v
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
  %final = fcmp ole double %left, %h
  %usedup = icmp uge i64 %sampled, %count
  %islast = icmp ne i64 %last, 0
  %ending0 = and i1 %usedup, %islast
  %ending = and i1 %ending0, %final
  %nomore = xor i1 %islast, true
  %leave = and i1 %usedup, %nomore
  br i1 %leave, label %filled, label %move
move:
  %left1 = fsub double %stop, %t
  %left2 = fsub double %left1, %tl
  %hs = select i1 %ending, double %left2, double %h
  br label %update
update:
  %ui = phi i64 [ 0, %move ], [ %unext, %update ]
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
  br i1 %ending, label %ended, label %advanced
advanced:
  store double %h, ptr %hpa, align 8
  %taken1 = add i64 %taken, 1
  br i1 %finite, label %step, label %again
again:
  call void @clear(ptr %work, i64 @@work_size@@)
  br label %step
ended:
  %taken2 = add i64 %taken, 1
  br label %return
paused:
  br label %return
singular:
  br label %return
notfinite:
  br label %return
stuckat:
  br label %return
filled:
  br label %return
return:
  %code = phi i64 [ @@end@@, %ended ], [ @@pause@@, %paused ], [ @@singular@@, %singular ], [ @@not_finite@@, %notfinite ], [ @@underflow@@, %stuckat ], [ @@samples@@, %filled ]
  %used = phi i64 [ %sampled, %ended ], [ %index, %paused ], [ %index, %singular ], [ %index, %notfinite ], [ %index, %stuckat ], [ %sampled, %filled ]
  %steps = phi i64 [ %taken2, %ended ], [ %taken, %paused ], [ %taken, %singular ], [ %taken, %notfinite ], [ %taken, %stuckat ], [ %taken, %filled ]
  store i64 %used, ptr %info, align 8
  store i64 %steps, ptr %stepsa, align 8
  ret i64 %code
}
