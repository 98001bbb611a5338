; The stepping loop in double-double, with @@names@@ filled in by twofold_stepper.py; compare stepper.ll.
define internal void @clear(ptr %place, i64 %count) #0 {
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

define i64 @accelerate(ptr %constants, double %t, ptr %state, ptr %work, ptr %rates) #0 {
  %regular = call i1 @jet(ptr %constants, double %t, double 0.0, ptr %state, ptr %work)
  call void @rates(ptr %work, ptr %rates)
  %code = zext i1 %regular to i64
  ret i64 %code
}

define i64 @advance(ptr %constants, ptr %state, ptr %work, ptr %trial, double %stop, ptr %times, i64 %count, ptr %out, i64 %stride, i64 %last, i64 %pause, ptr %info) #0 {
entry:
  %tpa = getelementptr inbounds double, ptr %state, i64 @@time@@
  %tla = getelementptr inbounds double, ptr %tpa, i64 1
  %hpa = getelementptr inbounds double, ptr %tpa, i64 2
  %stepsa = getelementptr inbounds i64, ptr %info, i64 1
  %beyond = mul i64 %stride, @@rows@@
  br label %step
step:
  %index = phi i64 [ 0, %entry ], [ %at, %advanced ]
  %taken = phi i64 [ 0, %entry ], [ %taken1, %advanced ]
  %enough = icmp uge i64 %taken, %pause
  br i1 %enough, label %paused, label %expand
expand:
  %t = load double, ptr %tpa, align 8
  %tl = load double, ptr %tla, align 8
  %hp = load double, ptr %hpa, align 8
  %regular = call i1 @jet(ptr %constants, double %t, double %tl, ptr %state, ptr %work)
  br i1 %regular, label %measure, label %singular
measure:
  %isfirst = fcmp oeq double %hp, 0.0
  br i1 %isfirst, label %first, label %usual
first:
  %g0 = call double @length(ptr %state, ptr %work, double 1.0)
  %g1 = call double @length(ptr %state, ptr %work, double %g0)
  br label %careful
usual:
  %hu = call double @length(ptr %state, ptr %work, double %hp)
  %leap = fmul double %hp, 4.0
  %isleap = fcmp ogt double %hu, %leap
  br i1 %isleap, label %careful, label %chosen
careful:
  %guess = phi double [ %g1, %first ], [ %hu, %usual ]
  br label %vet
vet:
  %hc = phi double [ %guess, %careful ], [ %shorter, %reject ]
  %tries = phi i64 [ 0, %careful ], [ %tries1, %reject ]
  %left0 = fsub double %stop, %t
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
  %h = phi double [ %hu, %usual ], [ %hc, %vet ]
  %finite = fcmp ord double %h, 0.0
  br i1 %finite, label %long, label %notfinite
long:
  %ts = call double @llvm.fabs.f64(double %t)
  %ulp = fmul double %ts, @@resolution@@
  %floor = fadd double %ulp, 0x0010000000000000
  %left1 = fsub double %stop, %t
  %left = fsub double %left1, %tl
  %tiny = fcmp ole double %h, %floor
  %short = fcmp olt double %h, %left
  %stuck = and i1 %tiny, %short
  br i1 %stuck, label %stuckat, label %sampling
sampling:
  %at = phi i64 [ %index, %long ], [ %atn, %dense ]
  %sa = getelementptr inbounds double, ptr %times, i64 %at
  %s = load double, ptr %sa, align 8
  %away = call %twofold @since(double %s, double %t, double %tl)
  %dt = extractvalue %twofold %away, 0
  %dtl = extractvalue %twofold %away, 1
  %within = fcmp ole double %dt, %h
  br i1 %within, label %dense, label %sampledall
dense:
  %place = getelementptr inbounds double, ptr %out, i64 %at
  call void @sample(ptr %state, ptr %work, double %dt, double %dtl, ptr %place, i64 %stride, i64 %beyond)
  %atn = add i64 %at, 1
  br label %sampling
sampledall:
  %final = fcmp ole double %left, %h
  %usedup = icmp uge i64 %at, %count
  %islast = icmp ne i64 %last, 0
  %ending0 = and i1 %usedup, %islast
  %ending = and i1 %ending0, %final
  %nomore = xor i1 %islast, true
  %leave = and i1 %usedup, %nomore
  br i1 %leave, label %filled, label %move
move:
  %rest = call %twofold @since(double %stop, double %t, double %tl)
  %resth = extractvalue %twofold %rest, 0
  %restl = extractvalue %twofold %rest, 1
  %hs = select i1 %ending, double %resth, double %h
  %hl = select i1 %ending, double %restl, double 0.0
  call void @update(ptr %state, ptr %work, double %hs, double %hl)
  %clock = call %twofold @twofold_add(double %t, double %tl, double %hs, double %hl)
  %tnew = extractvalue %twofold %clock, 0
  %tlnew = extractvalue %twofold %clock, 1
  store double %tnew, ptr %tpa, align 8
  store double %tlnew, ptr %tla, align 8
  br i1 %ending, label %ended, label %advanced
advanced:
  store double %h, ptr %hpa, align 8
  %taken1 = add i64 %taken, 1
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
  %used = phi i64 [ %at, %ended ], [ %index, %paused ], [ %index, %singular ], [ %index, %notfinite ], [ %index, %stuckat ], [ %at, %filled ]
  %steps = phi i64 [ %taken2, %ended ], [ %taken, %paused ], [ %taken, %singular ], [ %taken, %notfinite ], [ %taken, %stuckat ], [ %taken, %filled ]
  store i64 %used, ptr %info, align 8
  store i64 %steps, ptr %stepsa, align 8
  ret i64 %code
}
